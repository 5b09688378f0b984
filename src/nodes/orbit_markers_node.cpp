#include "amb_rotor/ros/node_setup.hpp"
#include "amb_rotor/ros/orbit_markers.hpp"

int main(int argc, char** argv) {
  return amb_rotor::runNode<amb_rotor::OrbitMarkers>(argc, argv, "orbit_markers");
}
