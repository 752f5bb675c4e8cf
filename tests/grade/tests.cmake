# Grading: the exercises, each with its solution and with wrong programs; and what holds for all, a class of tests an entry.
foreach(exercise bipartite byzantine flood gradient independent_set leader mutual_exclusion spanning_tree sum termination)
  add_test(NAME grade_${exercise} COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/exercises_test.py
    --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim> Exercises.test_${exercise})
  set_tests_properties(grade_${exercise} PROPERTIES TIMEOUT 120)
endforeach()
add_test(NAME grade_list COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/exercises_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim> All)
foreach(class Hostile Pages Copies Going Mistakes)
  string(TOLOWER ${class} name)
  add_test(NAME grade_${name} COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/grade_test.py
    --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim> ${class})
  set_tests_properties(grade_${name} PROPERTIES TIMEOUT 120)
endforeach()
