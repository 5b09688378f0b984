# AMB_ROTOR_WITH_ROS, the catkin components, and where Python modules are built.

# ROS's hooks print a line where it names another distribution, and catkin would read that line as Python.
unset(ENV{ROS_DISTRO})
if(NOT DEFINED AMB_ROTOR_WITH_ROS)
  find_package(catkin QUIET)
  option(AMB_ROTOR_WITH_ROS "nodes, messages and rostests" ${catkin_FOUND})
endif()

set(AMB_ROTOR_PYTHON_OUTPUT "${CMAKE_BINARY_DIR}/python/amb_rotor")
if(NOT AMB_ROTOR_WITH_ROS)
  message(STATUS "amb_rotor: without ROS")
  return()
endif()

# Nobody reads our messages in Lisp.
if(NOT DEFINED ENV{ROS_LANG_DISABLE})
  set(ENV{ROS_LANG_DISABLE} genlisp)
endif()
set(AMB_ROTOR_RUN_COMPONENTS
  roscpp roslib rosgraph_msgs std_msgs std_srvs geometry_msgs visualization_msgs
  diagnostic_msgs diagnostic_updater nodelet pluginlib rosbag rosbag_storage tf2 tf2_ros)
find_package(catkin REQUIRED COMPONENTS ${AMB_ROTOR_RUN_COMPONENTS} message_generation)

# Python packages in the source tree, made visible in the devel space and installed.
catkin_python_setup()

# Destinations that catkin_package() sets later; the core comes before it.
catkin_destinations()
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY "${CATKIN_DEVEL_PREFIX}/${CATKIN_PACKAGE_LIB_DESTINATION}")
set(CMAKE_ARCHIVE_OUTPUT_DIRECTORY "${CATKIN_DEVEL_PREFIX}/${CATKIN_PACKAGE_LIB_DESTINATION}")
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${CATKIN_DEVEL_PREFIX}/${CATKIN_PACKAGE_BIN_DESTINATION}")
set(AMB_ROTOR_PYTHON_OUTPUT "${CATKIN_DEVEL_PREFIX}/${CATKIN_PACKAGE_PYTHON_DESTINATION}")
