# amb_rotor._core: the core for Python.
file(GLOB module_sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/src/python/*.cpp")
if(module_sources)
  find_package(Python3 REQUIRED COMPONENTS Interpreter Development.Module)
  find_package(pybind11 REQUIRED)
  # NO_EXTRAS: link-time optimisation costs minutes and would mix the instruction sets of the lanes.
  pybind11_add_module(amb_rotor_module MODULE NO_EXTRAS ${module_sources})
  target_link_libraries(amb_rotor_module PRIVATE amb_rotor_core)
  amb_rotor_warnings(amb_rotor_module)
  amb_rotor_unity(amb_rotor_module 5 ${module_sources})
  set_target_properties(amb_rotor_module PROPERTIES
    OUTPUT_NAME _core
    LIBRARY_OUTPUT_DIRECTORY "${AMB_ROTOR_PYTHON_OUTPUT}")
endif()
