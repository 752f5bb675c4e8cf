# Sweeps: their rows and what is kept of them, a class of tests an entry.
foreach(class Rows Figures Measures Mistakes Going Memory Costs)
  string(TOLOWER ${class} name)
  add_test(NAME study_${name} COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/sweep_test.py
    --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim> ${class})
  set_tests_properties(study_${name} PROPERTIES TIMEOUT 120)
endforeach()

# Failed rows, made small.
foreach(class Smallest Ways)
  string(TOLOWER ${class} name)
  add_test(NAME shrink_${name} COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/shrink_test.py
    --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim> ${class})
  set_tests_properties(shrink_${name} PROPERTIES TIMEOUT 170)
endforeach()

# What is said of runs.
foreach(class Recordings Checkpoints Rows Mistakes)
  string(TOLOWER ${class} name)
  add_test(NAME about_${name} COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/about_test.py
    --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim> ${class})
  set_tests_properties(about_${name} PROPERTIES TIMEOUT 120)
endforeach()
