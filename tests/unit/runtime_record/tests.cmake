# Recordings as an outsider reads them: with h5py. Debian's Python has it; another one may not.
add_executable(test_runtime_record_writer ${CMAKE_CURRENT_LIST_DIR}/python/write_recording.cpp)
target_link_libraries(test_runtime_record_writer PRIVATE runtime_record)
find_program(MELD_SYSTEM_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH)
foreach(check layout killed full-disk)
  add_test(NAME test_runtime_record_${check}
           COMMAND ${MELD_SYSTEM_PYTHON} ${CMAKE_CURRENT_LIST_DIR}/python/check_recording.py $<TARGET_FILE:test_runtime_record_writer> ${check})
  set_tests_properties(test_runtime_record_${check} PROPERTIES TIMEOUT 300)
endforeach()
