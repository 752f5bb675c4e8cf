# Random programs against the reference evaluator.
file(GLOB reference_sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_LIST_DIR}/*/*.cpp)
add_library(tests_reference STATIC ${reference_sources}
            ${CMAKE_CURRENT_SOURCE_DIR}/retraction/case.cpp ${CMAKE_CURRENT_SOURCE_DIR}/retraction/graph_case.cpp
            ${CMAKE_CURRENT_SOURCE_DIR}/retraction/changes.cpp)
meld_unite(tests_reference)
# A folder at a time: in another one the same names mean other things.
set_target_properties(tests_reference PROPERTIES UNITY_BUILD_MODE GROUP)
foreach(source ${reference_sources})
  get_filename_component(room ${source} DIRECTORY)
  get_filename_component(room ${room} NAME)
  set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${room})
endforeach()
meld_precompile(tests_reference meld_precompiled)
target_link_libraries(tests_reference PUBLIC compiler_driver runtime_ask_debug runtime_results_record runtime_module_load meld_eigen)

add_executable(test_random ${CMAKE_CURRENT_LIST_DIR}/main.cpp)
target_link_libraries(test_random PRIVATE tests_reference)
# meld_random_test(NAME FIRST SEEDS MORE options ...): so many seeds from the first on, and MORE after these in NAME_more, a long test.
function(meld_random_test name first seeds more)
  math(EXPR next "${first} + ${seeds}")
  set(options ${ARGN} --jobs 2 --out ${CMAKE_BINARY_DIR}/random_failures)
  add_test(NAME ${name} COMMAND test_random --first ${first} --seeds ${seeds} ${options})
  add_test(NAME ${name}_more COMMAND test_random --first ${next} --seeds ${more} ${options})
  set_tests_properties(${name} ${name}_more PROPERTIES TIMEOUT 600 PROCESSORS 2)
  set_tests_properties(${name}_more PROPERTIES LABELS long)
endfunction()
meld_random_test(random_programs 1 15 35 --shipped 16)
# In graphs, and beside variants.
meld_random_test(random_graphs 1 8 8 --shipped 0 --graphs --failures)
add_test(NAME random_variants
         COMMAND test_random --seeds 8 --worlds 1 --shipped 0 --jobs 2 --graphs --variants --out ${CMAKE_BINARY_DIR}/random_failures)
set_tests_properties(random_variants PROPERTIES TIMEOUT 600 PROCESSORS 2)
# As users run them, over MPI.
meld_sizes_test(random_processes ${CMAKE_CURRENT_LIST_DIR}/processes_test.py --random $<TARGET_FILE:test_random>
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
set_tests_properties(random_processes_sizes PROPERTIES TIMEOUT 1800)
# The campaign goes on where the default runs end.
add_test(NAME random_programs_campaign
         COMMAND test_random --first 51 --seeds 1950 --shipped 16 --jobs 2 --out ${CMAKE_BINARY_DIR}/random_failures)
set_tests_properties(random_programs_campaign PROPERTIES TIMEOUT 2400 PROCESSORS 2 LABELS campaign)
foreach(mode "graphs" "graphs;failures;disturbed" "graphs;networks" "graphs;variants" "variants" "networks;disturbed" "failures;disturbed")
  string(REPLACE ";" "_" name "${mode}")
  list(TRANSFORM mode PREPEND "--")
  add_test(NAME random_campaign_${name} COMMAND test_random ${mode} --first 51 --seeds 100000 --minutes 10 --shipped 16 --jobs 2
                                                --out ${CMAKE_BINARY_DIR}/random_failures)
  set_tests_properties(random_campaign_${name} PROPERTIES TIMEOUT 1200 PROCESSORS 2 LABELS campaign)
endforeach()

meld_test(test_reference COMPUTES SOURCES ${CMAKE_CURRENT_LIST_DIR}/reference_test.cpp ${CMAKE_CURRENT_LIST_DIR}/fixed_catoms_test.cpp
          DEPENDS tests_reference)
# That the tester notices what is wrong takes longest, and changes seldom; so does what its generator makes.
meld_slow_cases(test_reference Generator.MakesProgramsOfAllConstructs Tester.NoticesOtherPrograms
  Tester.FindsNoDifferenceWhereThereIsNone Judge.NoticesEveryWayToFalsify Judge.AcceptsAnswersAboutPartsWithinParts
  Judge.AcceptsAnswersAndRefusesFalsifiedOnes Questions.AreOfManyKinds
  FixedCatoms.InLinearRulesAreLikeVariables)
meld_test(test_reference_types COMPUTES SOURCES ${CMAKE_CURRENT_LIST_DIR}/types_test.cpp DEPENDS tests_reference)
