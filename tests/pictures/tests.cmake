# Pictures of runs.
add_test(NAME pictures_shot COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/shot_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
set_tests_properties(pictures_shot PROPERTIES TIMEOUT 120 PROCESSORS 2)
