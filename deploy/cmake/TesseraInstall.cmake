# `cmake --install`: the programs into bin, the modules that they open into lib beside it, manual pages,
# completions, systemd units, the Python package and Blender's add-on, and documents. The target `programs` is
# all that these rules need, and no test.
add_custom_target(programs)

# The folder of man pages and completions that programs write of themselves, laid out like the prefix.
set(TESSERA_SELF_DESCRIPTIONS ${CMAKE_BINARY_DIR}/self-descriptions)
install(DIRECTORY ${TESSERA_SELF_DESCRIPTIONS}/share DESTINATION .)

# tessera_installed_program(TARGET)
function(tessera_installed_program name)
  install(TARGETS ${name} RUNTIME DESTINATION bin)
  add_custom_command(OUTPUT ${TESSERA_SELF_DESCRIPTIONS}/${name}.stamp
    COMMAND ${CMAKE_COMMAND} "-DCOMMAND=${CMAKE_CROSSCOMPILING_EMULATOR};$<TARGET_FILE:${name}>"
      -DNAME=${name} -DFOLDER=${TESSERA_SELF_DESCRIPTIONS}
      -P ${CMAKE_SOURCE_DIR}/deploy/cmake/describe_program.cmake
    DEPENDS ${name} ${CMAKE_SOURCE_DIR}/deploy/cmake/describe_program.cmake
    VERBATIM)
  add_custom_target(${name}-descriptions ALL DEPENDS ${TESSERA_SELF_DESCRIPTIONS}/${name}.stamp)
  add_dependencies(programs ${name} ${name}-descriptions)
endfunction()

# tessera_installed_module(TARGET): programs find it by their run path (TesseraOptions.cmake).
function(tessera_installed_module name)
  install(TARGETS ${name} LIBRARY DESTINATION lib)
  add_dependencies(programs ${name})
endfunction()

# The units name the programs of the prefix.
install(SCRIPT ${CMAKE_SOURCE_DIR}/deploy/cmake/install_units.cmake)
install(FILES deploy/systemd/tessera.conf DESTINATION lib/sysusers.d)

install(FILES LICENSE README.md CHANGELOG.md CONTRIBUTING.md DESTINATION share/doc/tessera)
install(DIRECTORY docs scenes DESTINATION share/doc/tessera)
install(DIRECTORY deploy/slurm deploy/kubernetes deploy/systemd DESTINATION share/doc/tessera/deploy)
