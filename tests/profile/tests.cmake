# What runs count, and where their time goes.
foreach(name counts profile)
  add_test(NAME profile_${name} COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/${name}_test.py
    --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
  set_tests_properties(profile_${name} PROPERTIES TIMEOUT 120 PROCESSORS 2)
endforeach()
