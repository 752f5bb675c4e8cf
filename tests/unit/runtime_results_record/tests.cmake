# Recordings as an outsider reads them: with h5py.
add_executable(test_runtime_results_record_writer ${CMAKE_CURRENT_LIST_DIR}/python/write_recording.cpp)
target_link_libraries(test_runtime_results_record_writer PRIVATE runtime_results_record)
add_dependencies(unit_tests test_runtime_results_record_writer)
# The same, and it lists its writes.
add_executable(test_runtime_results_record_listed_writer ${CMAKE_CURRENT_LIST_DIR}/python/write_recording.cpp
               ${CMAKE_CURRENT_LIST_DIR}/python/write_log.cpp)
target_link_libraries(test_runtime_results_record_listed_writer PRIVATE runtime_results_record ${CMAKE_DL_LIBS})
add_dependencies(unit_tests test_runtime_results_record_listed_writer)
foreach(check layout killed full-disk reopened)
  add_test(NAME test_runtime_results_record_${check}
           COMMAND ${CLAYMELD_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/python/check_recording.py
                   $<TARGET_FILE:test_runtime_results_record_writer> ${check})
  set_tests_properties(test_runtime_results_record_${check} PROPERTIES TIMEOUT 300)
endforeach()
# Of many catoms, with steps that hold changes alone.
foreach(check read reopened every-write)
  add_test(NAME test_runtime_results_record_changes_${check}
           COMMAND ${CLAYMELD_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/python/check_changes.py
                   $<TARGET_FILE:test_runtime_results_record_listed_writer> ${check})
  set_tests_properties(test_runtime_results_record_changes_${check} PROPERTIES TIMEOUT 300)
endforeach()
# A kill after each write: after some of them, and after all of a longer recording.
foreach(check every-write every-write-long reopened-every-write reopened-every-write-long)
  add_test(NAME test_runtime_results_record_${check}
           COMMAND ${CLAYMELD_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/python/check_recording.py
                   $<TARGET_FILE:test_runtime_results_record_listed_writer> ${check})
  set_tests_properties(test_runtime_results_record_${check} PROPERTIES TIMEOUT 3000)
endforeach()
set_tests_properties(test_runtime_results_record_every-write-long test_runtime_results_record_reopened-every-write-long
  PROPERTIES LABELS campaign)
