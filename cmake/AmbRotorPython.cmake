# Debian's ROS modules belong to /usr/bin/python3, even where another python3 comes first on the PATH.
if(EXISTS /usr/bin/python3)
  foreach(variable PYTHON_EXECUTABLE Python3_EXECUTABLE)
    if(NOT DEFINED ${variable})
      set(${variable} /usr/bin/python3 CACHE FILEPATH "the Python that ROS is installed for")
    endif()
  endforeach()
  # The scripts of catkin and ament that run while configuring look at the PATH.
  set(ENV{PATH} "/usr/bin:$ENV{PATH}")
else()
  find_package(Python3 REQUIRED COMPONENTS Interpreter)
  set(PYTHON_EXECUTABLE "${Python3_EXECUTABLE}" CACHE FILEPATH "the Python that ROS is installed for")
endif()
