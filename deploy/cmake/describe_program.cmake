# cmake "-DCOMMAND=PROGRAM" -DNAME=NAME -DFOLDER=FOLDER -P describe_program.cmake: writes the manual pages and
# the completions that the program prints, under FOLDER/share, and FOLDER/NAME.stamp. COMMAND may begin with an
# emulator's.

# take(VARIABLE ARGUMENTS...): what the program prints with these. Defaults in the text are those of a user
# whose home is ~.
function(take variable)
  execute_process(COMMAND ${CMAKE_COMMAND} -E env --unset=XDG_CACHE_HOME --unset=XDG_DATA_HOME HOME=~
    ASAN_OPTIONS=detect_leaks=0  # in a build with it, that is for tests to find
    ${COMMAND} ${ARGN} OUTPUT_VARIABLE text RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${NAME} ${ARGN}: ${result}")
  endif()
  set(${variable} "${text}" PARENT_SCOPE)
endfunction()

set(share ${FOLDER}/share)
take(text --completion bash)
file(WRITE ${share}/bash-completion/completions/${NAME} "${text}")
take(text --completion zsh)
file(WRITE ${share}/zsh/site-functions/_${NAME} "${text}")
take(text --completion fish)
file(WRITE ${share}/fish/vendor_completions.d/${NAME}.fish "${text}")

# The page of a program lists those of its commands: ".BR tessera\-render (1)".
take(text --man)
file(WRITE ${share}/man/man1/${NAME}.1 "${text}")
string(REGEX MATCHALL "\n\\.BR [^\n]* \\(1\\)" lines "${text}")
foreach(line ${lines})
  string(REGEX REPLACE "\n\\.BR (.*) \\(1\\)" "\\1" page "${line}")
  string(REPLACE "\\-" "-" page "${page}")
  string(REPLACE "${NAME}-" "" command "${page}")
  take(text --man ${command})
  file(WRITE ${share}/man/man1/${page}.1 "${text}")
endforeach()
file(TOUCH ${FOLDER}/${NAME}.stamp)
