"""amb_rotor: rotors on active magnetic bearings. Command line, pictures, reports, campaigns.

The package is spread over folders: these sources, the compiled core (`amb_rotor._core`) in the build
folder, and the generated messages (`amb_rotor.msg`) in the devel space.
"""
import pkgutil

__path__ = pkgutil.extend_path(__path__, __name__)
__version__ = "0.1.0"
