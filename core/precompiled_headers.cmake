# The headers from outside that most files include are parsed once for all of them. That is a third of the time it takes
# to build from nothing with GCC, two fifths with Clang. A file still includes all that it uses:
# -DANYRATE_PRECOMPILED_HEADERS=OFF finds what does not. Include this behind the last target.
set(common_headers <algorithm> <array> <chrono> <cmath> <cstddef> <cstdint> <cstdio> <cstdlib> <cstring> <filesystem>
    <fstream> <functional> <limits> <map> <memory> <numbers> <numeric> <optional> <random> <span> <string> <string_view>
    <utility> <vector> <Eigen/Geometry>)

# add_precompiled(NAME HEADER...): what others take them from
file(WRITE ${CMAKE_BINARY_DIR}/precompiled.cpp "")
function(add_precompiled name)
  add_library(${name} STATIC ${CMAKE_BINARY_DIR}/precompiled.cpp)
  target_link_libraries(${name} PRIVATE core_leaf Threads::Threads)
  target_precompile_headers(${name} PRIVATE ${ARGN})
endfunction()

# add_precompiled_headers(FOLDER): to all targets in it and below
function(add_precompiled_headers folder)
  get_property(targets DIRECTORY ${folder} PROPERTY BUILDSYSTEM_TARGETS)
  foreach(target ${targets})
    get_target_property(type ${target} TYPE)
    get_target_property(libraries ${target} LINK_LIBRARIES)
    if(NOT type MATCHES "STATIC_LIBRARY|EXECUTABLE" OR "${libraries}" MATCHES "OpenMP::")  # that has flags of its own
      continue()
    elseif(ANYRATE_SANITIZE AND target MATCHES "^(proto|core_capture)$")  # so do they
      target_precompile_headers(${target} PRIVATE ${common_headers})
    elseif("${libraries}" MATCHES "test_main|test_gpu_main")
      target_precompile_headers(${target} REUSE_FROM precompiled_tests)
    else()
      target_precompile_headers(${target} REUSE_FROM precompiled_code)
    endif()
  endforeach()
  get_property(folders DIRECTORY ${folder} PROPERTY SUBDIRECTORIES)
  foreach(below ${folders})
    add_precompiled_headers(${below})
  endforeach()
endfunction()

add_precompiled(precompiled_code ${common_headers})
set(folders core gpu proto server)
if(ANYRATE_TESTS)
  find_package(doctest REQUIRED)
  add_precompiled(precompiled_tests ${common_headers} <doctest/doctest.h>)
  list(APPEND folders tests)
endif()
foreach(folder ${folders})
  add_precompiled_headers(${folder})
endforeach()
