# A room is a folder of src: one static library that sees the headers of the rooms it links and of no other.
#
# isoextract_room(NAME SOURCES a.cpp ... ROOMS base field ... LIBRARIES Some::lib ...)
#
# Headers are included as "room/header.hpp". Every room publishes an include directory of its own that holds nothing
# but a link to its folder, so an include that crosses the link line does not compile.

add_library(isoextract_options INTERFACE)
target_compile_options(isoextract_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion
  -Wno-sign-conversion -Wold-style-cast -Wnon-virtual-dtor -Woverloaded-virtual -Wnull-dereference -ffp-contract=off)
if(ISOEXTRACT_WERROR)
  target_compile_options(isoextract_options INTERFACE -Werror)
endif()
if(ISOEXTRACT_SANITIZE)
  target_compile_options(isoextract_options INTERFACE
    -fsanitize=${ISOEXTRACT_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  target_link_options(isoextract_options INTERFACE -fsanitize=${ISOEXTRACT_SANITIZE})
endif()

function(isoextract_room name)
  cmake_parse_arguments(ROOM "" "" "SOURCES;ROOMS;LIBRARIES" ${ARGN})
  set(target isoextract_${name})
  set(include_dir ${PROJECT_BINARY_DIR}/include/${name})
  file(MAKE_DIRECTORY ${include_dir})
  file(CREATE_LINK ${CMAKE_CURRENT_SOURCE_DIR} ${include_dir}/${name} SYMBOLIC)
  add_library(${target} STATIC ${ROOM_SOURCES})
  target_include_directories(${target} PUBLIC ${include_dir})
  list(TRANSFORM ROOM_ROOMS PREPEND isoextract_)
  target_link_libraries(${target} PUBLIC ${ROOM_ROOMS} ${ROOM_LIBRARIES} PRIVATE isoextract_options)
endfunction()
