# File tests: programs with their expected output in the same file. One entry a folder; MELD_AUTOUPDATE=1 rewrites them.
# And the fixes of all messages, and what `meldc check` says of contradictions against trying numbers.
file(GLOB folders CONFIGURE_DEPENDS ${CMAKE_CURRENT_LIST_DIR}/*)
foreach(folder ${folders})
  get_filename_component(name ${folder} NAME)
  if(IS_DIRECTORY ${folder} AND NOT name STREQUAL "__pycache__")
    add_test(NAME meld_${name} COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/file_test.py
      --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim> ${folder})
  endif()
endforeach()
# Some of them in pieces, as very long modules are compiled.
foreach(name recursion negation undefined functions)
  add_test(NAME meld_${name}_in_pieces COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/file_test.py
    --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim> ${CMAKE_CURRENT_LIST_DIR}/${name})
  set_property(TEST meld_${name}_in_pieces APPEND PROPERTY ENVIRONMENT CLAYMELD_PARTS_OF_PIECE=2)
endforeach()
# All files with all numbers of processes and threads.
add_test(NAME meld_sizes COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/file_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim> ${CMAKE_CURRENT_LIST_DIR})
set_tests_properties(meld_sizes PROPERTIES TIMEOUT 1200 PROCESSORS 2 LABELS campaign ENVIRONMENT CLAYMELD_TEST_SIZES=all)
add_test(NAME meld_every_kind_is_shown COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/file_test.py
  --kinds ${CMAKE_SOURCE_DIR}/compiler/diagnostics/kinds.def ${CMAKE_CURRENT_LIST_DIR})
add_test(NAME meld_every_pass_is_tested COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/file_test.py
  --passes ${CMAKE_SOURCE_DIR}/compiler/plan/plan.cpp ${CMAKE_CURRENT_LIST_DIR}/passes)
add_test(NAME meld_every_construct_is_tested COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/file_test.py
  --constructs ${CMAKE_CURRENT_LIST_DIR}/constructs.toml ${CMAKE_SOURCE_DIR})
add_test(NAME meld_fixes COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/fixes_test.py --meldc $<TARGET_FILE:meldc>)
add_test(NAME meld_cures COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/cures_test.py --meldc $<TARGET_FILE:meldc>
  --meldsim $<TARGET_FILE:meldsim>)
add_test(NAME meld_contradictions COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/contradiction_test.py
  --meldc $<TARGET_FILE:meldc>)
set(chains_test ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/chains_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
add_test(NAME meld_chains COMMAND ${chains_test} --many 6000 Chains)
add_test(NAME meld_chains_more COMMAND ${chains_test} --many 30000 Chains)
set_tests_properties(meld_chains meld_chains_more PROPERTIES TIMEOUT 300 PROCESSORS 2)
set_tests_properties(meld_chains_more PROPERTIES LABELS long)
# Linear rules with every plan.
add_test(NAME meld_plans COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/plans_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim> --passes ${CMAKE_SOURCE_DIR}/compiler/plan/plan.cpp
  ${CMAKE_CURRENT_LIST_DIR}/linear/different_facts.meld ${CMAKE_CURRENT_LIST_DIR}/linear/different_facts_later.meld)
