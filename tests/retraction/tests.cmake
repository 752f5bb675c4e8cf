# Exactness under change, on programs compiled by meldc when the test runs.
file(GLOB retraction_sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_LIST_DIR}/*.cpp)
meld_test(test_retraction COMPUTES SOURCES ${retraction_sources} DEPENDS runtime/results/record runtime/module/load compiler/plan)
target_compile_definitions(test_retraction PRIVATE CLAYMELD_MELDC="$<TARGET_FILE:meldc>" CLAYMELD_PROGRAMS="${CMAKE_CURRENT_LIST_DIR}")
add_dependencies(test_retraction meldc)
# What a pass changes in programs that are like others.
set(like_others catoms closure flood joins keyed leader multihop parent perlink strata tree twolinks weighted widest)
list(TRANSFORM like_others PREPEND Programs/Passes.DeltasChangeNothing/)
meld_slow_cases(test_retraction Rewriting.ChangesNothing Programs/Passes.DeltasChangeNothing/rows Programs/Passes.DeltasChangeNothing/fronts
  Programs/Quarantine.IsNeeded/hops Programs/Retraction.LeavesNoTrace/perlink Programs/Retraction.LeavesNoTrace/twolinks ${like_others})
# Other cases than those above, and more.
add_test(NAME retraction_campaign COMMAND test_retraction --gtest_filter=*.LeavesNoTrace/*)
set_tests_properties(retraction_campaign PROPERTIES TIMEOUT 2400 PROCESSORS 2 LABELS campaign
  ENVIRONMENT "CLAYMELD_RETRACTION_FIRST=11;CLAYMELD_RETRACTION_SEEDS=456")
