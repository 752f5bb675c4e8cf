# The commands as a user meets them, a class of tests an entry.
foreach(class Usage Programs Worlds Files Endings Hostile)
  string(TOLOWER ${class} name)
  add_test(NAME cli_${name} COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/cli_test.py
    --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim> ${class})
endforeach()
add_test(NAME cli_messages COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/messages_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
# Very long programs.
add_test(NAME cli_pieces COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/pieces_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
set_tests_properties(cli_pieces PROPERTIES PROCESSORS 2 TIMEOUT 240)
# What they write, and where.
foreach(class Paths Locks Streams Shown Disks)
  string(TOLOWER ${class} name)
  add_test(NAME cli_outputs_${name} COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/outputs_test.py
    --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim> ${class})
endforeach()
# Facts as tables, read with the Python package.
foreach(class Tables Recorded Refusals Whole)
  string(TOLOWER ${class} name)
  add_test(NAME cli_facts_${name} COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/facts_test.py
    --meldsim $<TARGET_FILE:meldsim> ${class})
  set_tests_properties(cli_facts_${name} PROPERTIES ENVIRONMENT PYTHONPATH=${CMAKE_SOURCE_DIR}/python TIMEOUT 120)
endforeach()
# What two runs differ in.
foreach(class Digests Facts Recordings Checkpoints)
  string(TOLOWER ${class} name)
  add_test(NAME cli_diff_${name} COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/diff_test.py
    --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim> ${class})
  set_tests_properties(cli_diff_${name} PROPERTIES TIMEOUT 120)
endforeach()
# The memory that runs are expected to take. Sanitizers take their own.
if(NOT CLAYMELD_SANITIZE)
  set(memory_test ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/memory_test.py --meldsim $<TARGET_FILE:meldsim>)
  add_test(NAME cli_memory_estimates COMMAND ${memory_test} Estimates)
  add_test(NAME cli_memory_ranges COMMAND ${memory_test} Ranges)
  # Each example is compiled as users compile it.
  foreach(part 1 2 3 4)
    add_test(NAME cli_memory_examples_${part} COMMAND ${memory_test} --part ${part}/4 Examples)
  endforeach()
  set_tests_properties(cli_memory_estimates cli_memory_ranges cli_memory_examples_1 cli_memory_examples_2 cli_memory_examples_3
    cli_memory_examples_4 PROPERTIES TIMEOUT 120)
endif()
# What a user may trust.
foreach(class Cache Inputs Terminal Agreement)
  string(TOLOWER ${class} name)
  add_test(NAME trust_${name} COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/trust_test.py
    --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim> ${class})
  set_tests_properties(trust_${name} PROPERTIES TIMEOUT 120)
endforeach()
# Runs that are told to end; the campaign tells hundreds of them.
foreach(class Interrupts Launcher UsersOwn Random Stopped)
  string(TOLOWER ${class} name)
  add_test(NAME signals_${name} COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/signals_test.py
    --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim> ${class})
  set_tests_properties(signals_${name} PROPERTIES TIMEOUT 300)
endforeach()
add_test(NAME signals_campaign COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/signals_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim> --runs 150 Random)
set_tests_properties(signals_campaign PROPERTIES TIMEOUT 3600 PROCESSORS 2 LABELS campaign)
# Runs that are divided anew among their processes.
add_test(NAME cli_balance COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/balance_test.py --meldsim $<TARGET_FILE:meldsim>)
set_tests_properties(cli_balance PROPERTIES PROCESSORS 2 TIMEOUT 120)
