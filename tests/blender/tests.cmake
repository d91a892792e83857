# The Blender add-on as far as it works without Blender; scripts/blender/check runs it there. It needs numpy, as Blender
# has it, which Debian has for its own Python only.
find_program(DEBIAN_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH)
if(NOT DEBIAN_PYTHON)
  set(DEBIAN_PYTHON ${Python3_EXECUTABLE})
endif()
add_test(NAME blender.readers COMMAND ${DEBIAN_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/readers_test.py)
set_tests_properties(blender.readers PROPERTIES
  ENVIRONMENT "ISOEXTRACT_PROGRAM=$<TARGET_FILE:isoextract>;ISOEXTRACT_SOURCE_DIR=${PROJECT_SOURCE_DIR}"
  LABELS blender TIMEOUT 120)
