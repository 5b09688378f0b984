# Google Benchmark: one executable a file under bench/, in the target amb_rotor_bench.
find_package(benchmark REQUIRED)
add_custom_target(amb_rotor_bench)
file(GLOB bench_sources CONFIGURE_DEPENDS "${CMAKE_CURRENT_SOURCE_DIR}/bench/*.cpp")
find_package(SUNDIALS QUIET)
foreach(source IN LISTS bench_sources)
  get_filename_component(name "${source}" NAME_WE)
  amb_rotor_simd_sources("${source}")
  add_executable(bench_${name} EXCLUDE_FROM_ALL "${source}")
  set_target_properties(bench_${name} PROPERTIES
    OUTPUT_NAME ${name}
    RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/bench")
  target_compile_definitions(bench_${name} PRIVATE AMB_ROTOR_SOURCE_DIR="${CMAKE_CURRENT_SOURCE_DIR}")
  target_link_libraries(bench_${name} PRIVATE
    amb_rotor_core benchmark::benchmark benchmark::benchmark_main)
  if(TARGET SUNDIALS::cvode AND TARGET SUNDIALS::arkode)
    target_link_libraries(bench_${name} PRIVATE
      SUNDIALS::cvode SUNDIALS::arkode SUNDIALS::nvecserial SUNDIALS::sunnonlinsolfixedpoint)
    target_compile_definitions(bench_${name} PRIVATE AMB_ROTOR_WITH_SUNDIALS)
  endif()
  amb_rotor_warnings(bench_${name})
  add_dependencies(amb_rotor_bench bench_${name})
endforeach()
