# Networks that take time, and clocks that pause.
meld_sizes_test(networks ${CMAKE_CURRENT_LIST_DIR}/networks_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
meld_random_test(random_networks 5001 15 15 --networks --worlds 2 --shipped 0)
add_test(NAME random_networks_campaign COMMAND test_random --networks --first 5031 --seeds 600 --shipped 16 --jobs 2
  --out ${CMAKE_BINARY_DIR}/random_failures)
set_tests_properties(random_networks_campaign PROPERTIES TIMEOUT 2400 PROCESSORS 2 LABELS campaign)
# Clocks that give turns.
meld_sizes_test(networks_turns ${CMAKE_CURRENT_LIST_DIR}/turns_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
# Links that are cut, catoms that hang and restart, jams.
meld_sizes_test(failures ${CMAKE_CURRENT_LIST_DIR}/failures_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
meld_random_test(random_failures 6001 10 20 --failures --worlds 2 --shipped 0)
add_test(NAME random_failures_campaign COMMAND test_random --failures --first 6031 --seeds 600 --shipped 16 --jobs 2
  --out ${CMAKE_BINARY_DIR}/random_failures)
set_tests_properties(random_failures_campaign PROPERTIES TIMEOUT 2400 PROCESSORS 2 LABELS campaign)
# Facts to nodes that no link leads to.
meld_sizes_test(networks_far ${CMAKE_CURRENT_LIST_DIR}/far_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
# Nodes that rules make.
meld_sizes_test(networks_births ${CMAKE_CURRENT_LIST_DIR}/births_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
# Changes for which a neighbour is not evaluated.
meld_sizes_test(networks_concerned ${CMAKE_CURRENT_LIST_DIR}/concerned_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
# What a world says of catoms and links that are not there.
add_test(NAME networks_unmatched COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/unmatched_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
set_tests_properties(networks_unmatched PROPERTIES TIMEOUT 300 PROCESSORS 2)
