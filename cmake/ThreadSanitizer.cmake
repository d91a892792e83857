# The thread sanitizer needs a oneTBB that was built with it: where the library's own steps are unknown to it, it takes
# what a loop hands to its bodies for a race, and what hides that hides every race of the bodies as well.
# tests/tsan/planted_race_test.py shows both.
if(ISOEXTRACT_SANITIZE MATCHES "thread")
  set(TBB_DIR ${PROJECT_SOURCE_DIR}/build/tsan-tbb/lib/cmake/TBB CACHE PATH "oneTBB with the thread sanitizer" FORCE)
  find_package(TBB QUIET NO_DEFAULT_PATH)
  if(NOT TBB_FOUND)
    message(FATAL_ERROR "There is no oneTBB with the thread sanitizer: `scripts/tsan_tbb` builds it")
  endif()
endif()
