# A room is a folder of src: one static library of all its sources except main.cpp. It sees only the headers of the
# rooms that it links.
#
# isoextract_room(NAME [SHELL] ROOMS base field ... LIBRARIES Some::lib ...)
#
# SHELL: a release compiles the room with -O1. Its loops over vertices or triangles are a small part of any run.
#
# A unity build compiles each room as one file: most compile time goes into headers and templates.
#
# Headers are included as "room/header.hpp". Other rooms see an include directory with links to the headers at the
# room's top only. So an include of a room that is not linked, or of a header in a subfolder of another room, does not
# compile. The room itself and its unit tests see all of its headers.

add_library(isoextract_options INTERFACE)
target_compile_options(isoextract_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion
  -Wno-sign-conversion -Wold-style-cast -Wnon-virtual-dtor -Woverloaded-virtual -Wnull-dereference)
if(CMAKE_UNITY_BUILD)
  # A unity build includes the sources in a generated file, and GCC then warns about their anonymous namespaces.
  target_compile_options(isoextract_options INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
endif()
# Lets GCC use 2 GiB before it collects garbage, which took a fifth of the compile time (CompilerMemory.cmake).
target_compile_options(isoextract_options INTERFACE $<$<CXX_COMPILER_ID:GNU>:--param=ggc-min-heapsize=2097152>)
if(ISOEXTRACT_WERROR)
  # With -O3, GCC 12 warns of null pointers in the inlined destructor of Error.
  target_compile_options(isoextract_options INTERFACE -Werror
    $<$<AND:$<CXX_COMPILER_ID:GNU>,$<CONFIG:Release>>:-Wno-error=null-dereference>)
endif()
if(ISOEXTRACT_SANITIZE)
  target_compile_options(isoextract_options INTERFACE
    -fsanitize=${ISOEXTRACT_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(isoextract_options INTERFACE -fsanitize=${ISOEXTRACT_SANITIZE})
endif()

function(isoextract_room name)
  cmake_parse_arguments(ROOM "SHELL" "" "ROOMS;LIBRARIES" ${ARGN})
  set(target isoextract_${name})
  set(public_dir ${PROJECT_BINARY_DIR}/include/${name})
  set(private_dir ${PROJECT_BINARY_DIR}/include-all/${name})
  file(REMOVE_RECURSE ${public_dir})
  file(MAKE_DIRECTORY ${public_dir}/${name} ${private_dir})
  file(CREATE_LINK ${CMAKE_CURRENT_SOURCE_DIR} ${private_dir}/${name} SYMBOLIC)
  file(GLOB headers CONFIGURE_DEPENDS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR}/*.hpp)
  foreach(header IN LISTS headers)
    file(CREATE_LINK ${CMAKE_CURRENT_SOURCE_DIR}/${header} ${public_dir}/${name}/${header} SYMBOLIC)
  endforeach()
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} *.cpp)
  list(REMOVE_ITEM sources main.cpp)
  add_library(${target} STATIC ${sources})
  set_target_properties(${target} PROPERTIES UNITY_BUILD_BATCH_SIZE 0)
  target_include_directories(${target} PRIVATE ${private_dir} INTERFACE ${public_dir})
  list(TRANSFORM ROOM_ROOMS PREPEND isoextract_)
  target_link_libraries(${target} PUBLIC ${ROOM_ROOMS} ${ROOM_LIBRARIES} PRIVATE isoextract_options)
  if(ROOM_SHELL)
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  endif()
  isoextract_precompile(${target})
endfunction()

# Precompiles the headers that most files include, once for all rooms. Only for builds that often start from scratch:
# with precompiled headers, a file that lacks one of these includes goes unnoticed.
function(isoextract_precompile target)
  if(NOT ISOEXTRACT_PRECOMPILE)
    return()
  endif()
  if(target STREQUAL isoextract_base)
    target_precompile_headers(${target} PRIVATE
      <algorithm> <array> <cmath> <filesystem> <functional> <memory> <optional> <span> <sstream> <string> <vector>
      <fmt/format.h> <glm/glm.hpp> <tl/expected.hpp>)
  else()
    target_precompile_headers(${target} REUSE_FROM isoextract_base)
  endif()
endfunction()

# Lets the tests of a room include all headers of the room.
function(isoextract_see_all target room)
  target_include_directories(${target} BEFORE PRIVATE ${PROJECT_BINARY_DIR}/include-all/${room})
endfunction()
