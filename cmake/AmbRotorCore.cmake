# amb_rotor_core: all physics, integration and analysis. No ROS.
find_package(Eigen3 REQUIRED NO_MODULE)
find_package(yaml-cpp REQUIRED)
find_package(fmt REQUIRED)
find_package(TBB REQUIRED)
find_package(ZLIB REQUIRED)
find_package(Threads REQUIRED)

set(core_folders
  common model rotor magnetic_bearing auxiliary_bearing excitation sensing effects machine
  integration analysis identification validation)
set(core_patterns)
foreach(folder IN LISTS core_folders)
  list(APPEND core_patterns "${CMAKE_CURRENT_SOURCE_DIR}/src/${folder}/*.cpp")
endforeach()
file(GLOB core_sources CONFIGURE_DEPENDS ${core_patterns})
amb_rotor_simd_sources(${core_sources})

if(core_sources)
  add_library(amb_rotor_core SHARED ${core_sources})
  set(core_scope PUBLIC)
  amb_rotor_warnings(amb_rotor_core)
  target_compile_options(amb_rotor_core PRIVATE -O3)  # unrolls loops over ends, axes and nodes
  amb_rotor_unity(amb_rotor_core 8 ${core_sources})
  # half a minute each: side by side, on two cores
  set_source_files_properties("${CMAKE_CURRENT_SOURCE_DIR}/src/common/linear_algebra.cpp"
    "${CMAKE_CURRENT_SOURCE_DIR}/src/common/eigenvalues.cpp" PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
else()
  add_library(amb_rotor_core INTERFACE)
  set(core_scope INTERFACE)
endif()
target_include_directories(amb_rotor_core ${core_scope}
  $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:include>)
# One alignment for all translation units: without it an Eigen matrix compiled with AVX2 has another
# layout than the same matrix compiled with the baseline flags.
target_compile_definitions(amb_rotor_core ${core_scope} EIGEN_MAX_ALIGN_BYTES=16)
target_link_libraries(amb_rotor_core ${core_scope}
  Eigen3::Eigen yaml-cpp fmt::fmt TBB::tbb ZLIB::ZLIB Threads::Threads)
