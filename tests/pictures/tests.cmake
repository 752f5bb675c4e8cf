# Pictures of runs.
add_test(NAME pictures_shot COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/shot_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
set_tests_properties(pictures_shot PROPERTIES TIMEOUT 120 PROCESSORS 2)
add_test(NAME pictures_movie COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/movie_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
add_test(NAME pictures_steps COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/steps_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
add_test(NAME pictures_export COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/export_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
set_tests_properties(pictures_movie pictures_steps pictures_export PROPERTIES TIMEOUT 120 PROCESSORS 2)
# Compared with what they should be, also where something is wrong.
add_test(NAME pictures_looks COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/looks_test.py
  --meldc $<TARGET_FILE:meldc> --meldsim $<TARGET_FILE:meldsim>)
set_tests_properties(pictures_looks PROPERTIES TIMEOUT 120)
# The gallery: some of its pictures are made again; the campaign makes all.
add_test(NAME pictures_gallery COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/gallery_test.py
  --bin $<TARGET_FILE_DIR:meldsim> heat life ring belief_propagation)
set_tests_properties(pictures_gallery PROPERTIES TIMEOUT 120)
add_test(NAME pictures_gallery_campaign COMMAND ${CLAYMELD_PYTHON} -B ${CMAKE_CURRENT_LIST_DIR}/gallery_test.py
  --bin $<TARGET_FILE_DIR:meldsim>)
set_tests_properties(pictures_gallery_campaign PROPERTIES TIMEOUT 1800 LABELS campaign)
