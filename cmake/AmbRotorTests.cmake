# GoogleTest: one executable a folder under test/. rostest: test/ros/*.test with its C++ programs.
# All of them are in the target amb_rotor_tests; `amb test` builds and runs them.
find_package(GTest REQUIRED)
enable_testing()
if(NOT TARGET amb_rotor_tests)
  add_custom_target(amb_rotor_tests)
endif()
if(TARGET tests)  # catkin's name for the same thing
  add_dependencies(tests amb_rotor_tests)
endif()

# An independent integrator to check against; Boost.odeint, which is headers only, is always there.
find_package(SUNDIALS QUIET)

function(amb_rotor_test_executable target)
  add_executable(${target} EXCLUDE_FROM_ALL ${ARGN})
  target_compile_definitions(${target} PRIVATE AMB_ROTOR_SOURCE_DIR="${CMAKE_CURRENT_SOURCE_DIR}")
  target_link_libraries(${target} PRIVATE amb_rotor_core GTest::gmock GTest::gtest)
  amb_rotor_warnings(${target})
  target_compile_options(${target} PRIVATE -O1)  # they are compiled more often than they run; the libraries stay at -O2
  amb_rotor_unity(${target} 6 ${ARGN})
  list(LENGTH ARGN sources)
  # a second of each file's compile time is these headers', six to precompile them
  if(sources GREATER 6 AND NOT AMB_ROTOR_UNITY)
    target_precompile_headers(${target} PRIVATE <gmock/gmock.h> <gtest/gtest.h> <Eigen/Core>)
  endif()
  add_dependencies(amb_rotor_tests ${target})
endfunction()

foreach(folder unit reference property convergence validation)
  file(GLOB sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/test/${folder}/*.cpp")
  if(sources)
    amb_rotor_simd_sources(${sources})
    amb_rotor_test_executable(test_${folder} ${sources})
    target_link_libraries(test_${folder} PRIVATE GTest::gtest_main)
    if(TARGET SUNDIALS::cvode)
      target_link_libraries(test_${folder} PRIVATE SUNDIALS::cvode SUNDIALS::nvecserial)
      target_compile_definitions(test_${folder} PRIVATE AMB_ROTOR_WITH_SUNDIALS)
    endif()
    set_target_properties(test_${folder} PROPERTIES
      RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/test")
    add_test(NAME test_${folder} COMMAND test_${folder})
  endif()
endforeach()

if(AMB_ROTOR_WITH_ROS)
  file(GLOB ros_tests CONFIGURE_DEPENDS RELATIVE "${CMAKE_CURRENT_SOURCE_DIR}"
    "${CMAKE_CURRENT_SOURCE_DIR}/test/ros/*.test")
  file(GLOB ros_test_sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/test/ros/*.cpp")
  set(ros_test_targets)
  # test/ros/name.cpp becomes the executable `name` of the package, for <test pkg="amb_rotor" type="name">.
  foreach(source IN LISTS ros_test_sources)
    get_filename_component(name "${source}" NAME_WE)
    amb_rotor_test_executable(rostest_${name} "${source}")
    set_target_properties(rostest_${name} PROPERTIES
      OUTPUT_NAME ${name}
      RUNTIME_OUTPUT_DIRECTORY "${CATKIN_DEVEL_PREFIX}/${CATKIN_PACKAGE_BIN_DESTINATION}")
    target_link_libraries(rostest_${name} PRIVATE amb_rotor_ros)
    if(TARGET amb_rotor_generate_messages_cpp)
      add_dependencies(rostest_${name} amb_rotor_generate_messages_cpp)
    endif()
    list(APPEND ros_test_targets rostest_${name})
  endforeach()
  if(ros_tests AND CATKIN_ENABLE_TESTING)
    find_package(rostest REQUIRED)
    foreach(file IN LISTS ros_tests)
      add_rostest(${file} DEPENDENCIES ${ros_test_targets} ${AMB_ROTOR_NODES})
    endforeach()
  endif()
endif()
