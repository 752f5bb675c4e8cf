# Worlds from files of other programs.
add_test(NAME worlds_models COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/models_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
set_tests_properties(worlds_models PROPERTIES TIMEOUT 120 PROCESSORS 2)
# Worlds that are graphs, compared with networkx.
add_test(NAME worlds_graphs COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/graphs_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
set_tests_properties(worlds_graphs PROPERTIES TIMEOUT 120 PROCESSORS 2)
# Worlds whose catoms run different programs.
add_test(NAME worlds_programs COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/programs_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
set_tests_properties(worlds_programs PROPERTIES TIMEOUT 120 PROCESSORS 2)
# Ports with the numbers of other robots.
add_test(NAME worlds_ports COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/ports_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
set_tests_properties(worlds_ports PROPERTIES TIMEOUT 180 PROCESSORS 2)
# Worlds of points with a range, compared with all pairs.
add_test(NAME worlds_points COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/points_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
set_tests_properties(worlds_points PROPERTIES TIMEOUT 600 PROCESSORS 2)
# Robots of several bodies, compared with what is written by hand.
add_test(NAME worlds_robots COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/robots_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
set_tests_properties(worlds_robots PROPERTIES TIMEOUT 300 PROCESSORS 2)
