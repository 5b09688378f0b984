# Messages, the library of node classes, one executable a node, the nodelets.
file(GLOB message_files CONFIGURE_DEPENDS RELATIVE "${CMAKE_CURRENT_SOURCE_DIR}/msg"
  "${CMAKE_CURRENT_SOURCE_DIR}/msg/*.msg")
file(GLOB service_files CONFIGURE_DEPENDS RELATIVE "${CMAKE_CURRENT_SOURCE_DIR}/srv"
  "${CMAKE_CURRENT_SOURCE_DIR}/srv/*.srv")
if(message_files)
  add_message_files(DIRECTORY msg FILES ${message_files})
endif()
if(service_files)
  add_service_files(DIRECTORY srv FILES ${service_files})
endif()
if(message_files OR service_files)
  generate_messages(DEPENDENCIES std_msgs geometry_msgs)
endif()

# generate_messages() shows the generated headers to every target of the folder; the core may not see them.
get_target_property(core_type amb_rotor_core TYPE)
if(NOT core_type STREQUAL "INTERFACE_LIBRARY")
  get_target_property(core_includes amb_rotor_core INCLUDE_DIRECTORIES)
  list(REMOVE_ITEM core_includes "${CATKIN_DEVEL_PREFIX}/include")
  set_target_properties(amb_rotor_core PROPERTIES INCLUDE_DIRECTORIES "${core_includes}")
endif()

file(GLOB ros_sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/src/ros/*.cpp")
file(GLOB nodelet_sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/src/nodes/*_nodelets.cpp")
file(GLOB node_sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/src/nodes/*_node.cpp")

set(exported_libraries amb_rotor_core)
if(ros_sources)
  list(APPEND exported_libraries amb_rotor_ros)
endif()
catkin_package(
  INCLUDE_DIRS include
  LIBRARIES ${exported_libraries}
  CATKIN_DEPENDS ${AMB_ROTOR_RUN_COMPONENTS} message_runtime
  DEPENDS EIGEN3)

# amb_rotor_ros_target(TARGET SCOPE): a target that sees ROS, waits for our generated headers, and
# sees the headers of ROS as a system's (their warnings are not ours).
function(amb_rotor_ros_target target scope)
  target_include_directories(${target} SYSTEM ${scope}
    "${CATKIN_DEVEL_PREFIX}/include" ${catkin_INCLUDE_DIRS})
  target_link_libraries(${target} ${scope} amb_rotor_core ${catkin_LIBRARIES})
  if(NOT scope STREQUAL "INTERFACE")
    amb_rotor_warnings(${target})
    if(TARGET amb_rotor_generate_messages_cpp)
      add_dependencies(${target} amb_rotor_generate_messages_cpp)
    endif()
  endif()
endfunction()
file(MAKE_DIRECTORY "${CATKIN_DEVEL_PREFIX}/include")

if(ros_sources)
  add_library(amb_rotor_ros SHARED ${ros_sources})
  amb_rotor_ros_target(amb_rotor_ros PUBLIC)
  amb_rotor_unity(amb_rotor_ros 8 ${ros_sources})
else()
  add_library(amb_rotor_ros INTERFACE)
  amb_rotor_ros_target(amb_rotor_ros INTERFACE)
endif()

set(AMB_ROTOR_NODES)
foreach(source IN LISTS node_sources)
  get_filename_component(name "${source}" NAME_WE)
  # Targets share one name space with messages and libraries: prefix the target, not the executable.
  add_executable(node_${name} "${source}")
  set_target_properties(node_${name} PROPERTIES OUTPUT_NAME ${name})
  target_link_libraries(node_${name} PRIVATE amb_rotor_ros)
  amb_rotor_warnings(node_${name})
  if(TARGET amb_rotor_generate_messages_cpp)
    add_dependencies(node_${name} amb_rotor_generate_messages_cpp)
  endif()
  list(APPEND AMB_ROTOR_NODES node_${name})
endforeach()

if(nodelet_sources)
  add_library(amb_rotor_nodelets SHARED ${nodelet_sources})
  target_link_libraries(amb_rotor_nodelets PRIVATE amb_rotor_ros)
  amb_rotor_warnings(amb_rotor_nodelets)
  if(TARGET amb_rotor_generate_messages_cpp)
    add_dependencies(amb_rotor_nodelets amb_rotor_generate_messages_cpp)
  endif()
endif()
