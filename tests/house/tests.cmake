# The rules of the house: what may include what, who may print, how long a file may be.
# The presets of the sanitizers leave them out by their label: they look at the sources, not at the program.
function(isoextract_house_test name)
  add_test(NAME house.${name} COMMAND Python3::Interpreter -B ${ARGN})
  set_tests_properties(house.${name} PROPERTIES LABELS house)
endfunction()

isoextract_house_test(rules ${CMAKE_CURRENT_LIST_DIR}/rules.py ${PROJECT_SOURCE_DIR})
isoextract_house_test(rules_find_what_is_planted ${CMAKE_CURRENT_LIST_DIR}/rules_test.py)
isoextract_house_test(words_find_what_is_planted ${CMAKE_CURRENT_LIST_DIR}/words_test.py ${PROJECT_SOURCE_DIR})
isoextract_house_test(crossing_include_does_not_compile
  ${CMAKE_CURRENT_LIST_DIR}/crossing_test.py ${PROJECT_SOURCE_DIR} ${PROJECT_BINARY_DIR})
isoextract_house_test(messages_are_on_their_page
  ${CMAKE_CURRENT_LIST_DIR}/messages_test.py ${PROJECT_SOURCE_DIR})
isoextract_house_test(pages_lead_somewhere ${CMAKE_CURRENT_LIST_DIR}/pages_test.py ${PROJECT_SOURCE_DIR})
isoextract_house_test(a_build_tells_how_far_it_is ${CMAKE_CURRENT_LIST_DIR}/build_progress_test.py ${PROJECT_SOURCE_DIR})
isoextract_house_test(measurements_are_what_their_json_gives
  ${CMAKE_CURRENT_LIST_DIR}/measure_test.py ${PROJECT_SOURCE_DIR})
# Debian's Python has NumPy; another one may not.
add_test(NAME house.figures_of_masks_are_right
  COMMAND /usr/bin/python3 -B ${CMAKE_CURRENT_LIST_DIR}/mask_quality_test.py ${PROJECT_SOURCE_DIR})
set_tests_properties(house.figures_of_masks_are_right PROPERTIES LABELS house)

# Not under the sanitizers: it says nothing there and is slow to compile.
if(NOT ISOEXTRACT_SANITIZE)
  set_target_properties(make_samples PROPERTIES EXCLUDE_FROM_ALL OFF)
  isoextract_house_test(samples_are_what_make_samples_writes
    ${CMAKE_CURRENT_LIST_DIR}/samples_test.py $<TARGET_FILE:make_samples> ${PROJECT_SOURCE_DIR}/samples)
endif()
