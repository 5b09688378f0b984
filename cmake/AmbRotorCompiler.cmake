# Language, build type, warnings, ccache.
if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Release, RelWithDebInfo or Debug" FORCE)
endif()

set(CMAKE_CXX_STANDARD 17)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)

# No -ffast-math: the located events and the error estimates rely on IEEE arithmetic and on NaN.
# NDEBUG switches off the assertions of the libraries (Eigen); AMB_ROTOR_CHECK stays in all builds.
set(CMAKE_CXX_FLAGS_RELEASE "-O2 -DNDEBUG")

find_program(AMB_ROTOR_CCACHE ccache)
if(AMB_ROTOR_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # precompiled headers: what they define is part of their own hash
  set(CMAKE_CXX_COMPILER_LAUNCHER env CCACHE_SLOPPINESS=pch_defines,time_macros "${AMB_ROTOR_CCACHE}")
endif()

option(AMB_ROTOR_SANITIZE "address and undefined-behaviour sanitizers" OFF)
if(AMB_ROTOR_SANITIZE)
  add_compile_options(-fsanitize=address,undefined -fno-omit-frame-pointer)
  add_link_options(-fsanitize=address,undefined)
endif()

# amb_rotor_warnings(TARGET...): our own code is free of warnings.
function(amb_rotor_warnings)
  foreach(target IN LISTS ARGN)
    target_compile_options(${target} PRIVATE -Wall -Wextra)
  endforeach()
endfunction()

# amb_rotor_unity(TARGET MOST SOURCE...): up to MOST files of one folder are compiled as one, which reads the headers and
# instantiates the templates once. OFF while working on one file: then only that file is compiled again.
option(AMB_ROTOR_UNITY "compile several files as one" ON)
function(amb_rotor_unity target most)
  if(NOT AMB_ROTOR_UNITY)
    return()
  endif()
  set(last_folder)
  set(group 0)
  set(count 0)
  foreach(source IN LISTS ARGN)
    if(source MATCHES "_(baseline|avx2|avx512)\\.cpp$")  # an instruction set each
      set_source_files_properties("${source}" PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
      continue()
    endif()
    get_filename_component(folder "${source}" DIRECTORY)
    if(NOT folder STREQUAL last_folder OR count EQUAL most)
      math(EXPR group "${group} + 1")
      set(count 0)
      set(last_folder "${folder}")
    endif()
    math(EXPR count "${count} + 1")
    set_source_files_properties("${source}" PROPERTIES UNITY_GROUP "group_${group}")
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
endfunction()

# amb_rotor_simd_sources(SOURCE...): files named *_avx2.cpp and *_avx512.cpp get their instruction set,
# every other file the baseline of the machine's architecture. The code selects one at run time.
# -O3 unrolls the loops over ends and axes, so that packs stay in registers.
# (GCC 12 warns of uninitialised values inside its own AVX-512 headers.)
function(amb_rotor_simd_sources)
  if(NOT CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64|amd64")
    return()
  endif()
  foreach(source IN LISTS ARGN)
    if(source MATCHES "_(avx2|avx512)\\.cpp$")  # headers precompiled for another instruction set do not fit
      set_source_files_properties("${source}" PROPERTIES SKIP_PRECOMPILE_HEADERS ON)
    endif()
    if(source MATCHES "_avx2\\.cpp$")
      set_source_files_properties("${source}" PROPERTIES COMPILE_OPTIONS "-O3;-mavx2;-mfma")
    elseif(source MATCHES "_avx512\\.cpp$")
      set_source_files_properties("${source}" PROPERTIES COMPILE_OPTIONS
        "-O3;-mavx512f;-mavx512dq;-mavx512vl;-mavx512bw;-mavx512cd;-mfma;-mprefer-vector-width=512;-Wno-uninitialized;-Wno-maybe-uninitialized")
    endif()
  endforeach()
endfunction()
