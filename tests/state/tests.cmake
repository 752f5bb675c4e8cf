# Runs that are stopped and go on.
meld_test(test_state SOURCES ${CMAKE_CURRENT_LIST_DIR}/snapshot_test.cpp ${CMAKE_CURRENT_LIST_DIR}/timeline_test.cpp
                              ${CMAKE_CURRENT_LIST_DIR}/damage_test.cpp ${CMAKE_CURRENT_LIST_DIR}/places_test.cpp
                              ${CMAKE_CURRENT_LIST_DIR}/fact_store_test.cpp
                              ${CMAKE_CURRENT_LIST_DIR}/liveness_test.cpp ${CMAKE_CURRENT_LIST_DIR}/inspect_test.cpp
                              ${CMAKE_CURRENT_LIST_DIR}/digest_test.cpp ${CMAKE_CURRENT_LIST_DIR}/kept_frame_test.cpp
          DEPENDS runtime/driver)
target_compile_definitions(test_state PRIVATE CLAYMELD_EXAMPLES="${CMAKE_SOURCE_DIR}/examples/meld"
                                              CLAYMELD_STATE_TESTS="${CMAKE_CURRENT_LIST_DIR}")
add_dependencies(test_state meldc)
# Of snapshots and timelines, what others are like: other worlds, components, engines and solvers.
set(like_others
  shortest_paths thermometerdrift thermometerweather life belief_propagation shape_change lost heappgs20 heaphash heapode
  pairhash pairode)
list(TRANSFORM like_others PREPEND Programs/*/)
meld_slow_cases(test_state ${like_others} Programs/Snapshot.*/tumble Programs/Snapshot.*/thermometer Programs/TimelineOf.*/doze
  Chains.OfWhichAnyByteOfTheLastFileIsDamagedFallBackToTheOneBefore Programs/Snapshot.*/heat Programs/Snapshot.*/walk
  Programs/Snapshot.*/leader Programs/Snapshot.*/cantilever Programs/Snapshot.*/mutual_exclusion Programs/TimelineOf.*/thermometer
  Programs/Snapshot.*/doze Programs/Snapshot.*/storm Programs/Snapshot.*/swarm Programs/TimelineOf.*/tumble Programs/TimelineOf.*/storm
  Damage.OfAnyByteOfAShareIsNoticed Damage.OfAnyByteOfAManifestIsNoticed)

add_test(NAME state_members COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/members_test.py ${CMAKE_SOURCE_DIR})
foreach(name bisect replay changes)
  add_test(NAME state_${name} COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/${name}_test.py
    --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
  set_tests_properties(state_${name} PROPERTIES TIMEOUT 300)
endforeach()
set_tests_properties(state_changes PROPERTIES ENVIRONMENT PYTHONPATH=${CMAKE_SOURCE_DIR}/python)
foreach(class Bodies Targets)
  string(TOLOWER ${class} name)
  add_test(NAME query_${name} COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/query_test.py
    --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim> ${class})
  set_tests_properties(query_${name} PROPERTIES TIMEOUT 300)
endforeach()
foreach(class Walks Questions OfRuns)
  string(TOLOWER ${class} name)
  add_test(NAME debug_${name} COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/debug_test.py
    --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim> ${class})
  set_tests_properties(debug_${name} PROPERTIES TIMEOUT 300)
endforeach()
foreach(name breaks by_hand dying)
  add_test(NAME debug_${name} COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/${name}_test.py
    --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
  set_tests_properties(debug_${name} PROPERTIES TIMEOUT 300)
endforeach()
foreach(class Save Reload)
  string(TOLOWER ${class} name)
  add_test(NAME debug_${name} COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/debug_state_test.py
    --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim> ${class})
  set_tests_properties(debug_${name} PROPERTIES TIMEOUT 300)
endforeach()
add_test(NAME debug_ataterminal COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/debug_terminal_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
set_tests_properties(debug_ataterminal PROPERTIES TIMEOUT 300)
foreach(class Watches Endings)
  string(TOLOWER ${class} name)
  add_test(NAME watch_${name} COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/watch_test.py
    --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim> ${class})
  set_tests_properties(watch_${name} PROPERTIES TIMEOUT 300)
endforeach()
add_test(NAME debug_walks_campaign COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/debug_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim> --walks 20 Walks)
set_tests_properties(debug_walks_campaign PROPERTIES TIMEOUT 3000 LABELS campaign)
add_test(NAME debug_why COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/why_test.py --meldc $<TARGET_FILE:meldc>
  --meldsim $<TARGET_FILE:meldsim>)
add_test(NAME debug_why_parts COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/why_parts_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
add_test(NAME debug_why_breaks COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/why_breaks_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
# Random programs; the campaign goes on where the default run ends.
set(judged test_random --why 12 --worlds 2 --shipped 0 --out ${CMAKE_BINARY_DIR}/random_failures)
add_test(NAME debug_why_random COMMAND ${judged} --seeds 8 --jobs 2)
add_test(NAME debug_why_campaign COMMAND ${judged} --first 9 --seeds 1506 --jobs 2)
set_tests_properties(debug_why debug_why_parts debug_why_breaks debug_why_random PROPERTIES TIMEOUT 300)
set_tests_properties(debug_why_random PROPERTIES PROCESSORS 2)
set_tests_properties(debug_why_campaign PROPERTIES TIMEOUT 3600 PROCESSORS 2 LABELS campaign)
set(asking_test ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/asking_test.py --meldc $<TARGET_FILE:meldc>
  --meldsim $<TARGET_FILE:meldsim> --test_random $<TARGET_FILE:test_random>)
foreach(class Messages Depends History Keys)
  string(TOLOWER ${class} name)
  add_test(NAME debug_${name} COMMAND ${asking_test} ${class})
endforeach()
add_test(NAME debug_asking_random COMMAND ${asking_test} --seeds 4 RandomAsked)
add_test(NAME debug_asking_campaign COMMAND ${asking_test} --seeds 60 RandomAsked)
set_tests_properties(debug_messages debug_depends debug_history debug_keys debug_asking_random PROPERTIES TIMEOUT 300)
set_tests_properties(debug_asking_campaign PROPERTIES TIMEOUT 3600 LABELS campaign)
foreach(class Ways Chains LongChains Damage Refusals)
  string(TOLOWER ${class} name)
  add_test(NAME state_${name} COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/resume_test.py
    --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim> ${class})
  set_tests_properties(state_${name} PROPERTIES TIMEOUT 300)
endforeach()
foreach(class Same OtherProgram OtherWorld Refusals)
  string(TOLOWER ${class} name)
  add_test(NAME fork_${name} COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/fork_test.py
    --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim> ${class})
  set_tests_properties(fork_${name} PROPERTIES TIMEOUT 300)
endforeach()
# Runs that are killed, at some tens of moments and at a thousand; another --seed kills at others.
set(state_kills ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/kills_test.py --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
add_test(NAME state_kills COMMAND ${state_kills} --kills 60)
set_tests_properties(state_kills PROPERTIES TIMEOUT 300)
add_test(NAME state_kills_campaign COMMAND ${state_kills} --kills 1000)
set_tests_properties(state_kills_campaign PROPERTIES TIMEOUT 3000 LABELS campaign)
# Kills, signals and full disks at random, for ten minutes; another --seed disturbs other runs.
add_test(NAME state_disturbances_campaign COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/disturb_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim> --seconds 600)
set_tests_properties(state_disturbances_campaign PROPERTIES TIMEOUT 3000 PROCESSORS 2 LABELS campaign)
# Runs that are supervised; the campaign kills them at hundreds of moments, and a change of shape too.
foreach(class Crashes Hangs Alone Killed)
  string(TOLOWER ${class} name)
  add_test(NAME supervision_${name} COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/supervision_test.py
    --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim> ${class})
  # They measure how long a run takes, and kill it within that.
  set_tests_properties(supervision_${name} PROPERTIES TIMEOUT 300 PROCESSORS 2)
endforeach()
add_test(NAME supervision_campaign COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/supervision_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim> --runs 10 --kills 10 Killed ShapeChange)
set_tests_properties(supervision_campaign PROPERTIES TIMEOUT 3600 PROCESSORS 2 LABELS campaign)

# Calls that write fail, one after the other: some, and all of them.
add_library(state_fail_calls MODULE ${CMAKE_CURRENT_LIST_DIR}/fail_calls.cpp)
target_link_libraries(state_fail_calls PRIVATE ${CMAKE_DL_LIBS})
add_dependencies(unit_tests state_fail_calls)
set(state_faults ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/faults_test.py --meldc $<TARGET_FILE:meldc>
  --meldsim $<TARGET_FILE:meldsim> --fail-calls $<TARGET_FILE:state_fail_calls>)
add_test(NAME state_faults COMMAND ${state_faults} --stride 13)
set_tests_properties(state_faults PROPERTIES TIMEOUT 300)
add_test(NAME state_faults_campaign COMMAND ${state_faults} --stride 3)
set_tests_properties(state_faults_campaign PROPERTIES TIMEOUT 3000 LABELS campaign)
