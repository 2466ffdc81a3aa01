# Opens a report in Chromium, on a screen as wide as a phone's and on one as
# wide as a desk's.
#
#   BROWSER  Chromium; PROGRAM  duet; FOLDER  to work in; CHECK  check.js
cmake_minimum_required(VERSION 3.22)
if(NOT BROWSER)
  message("no chromium here: skipped (apt install chromium)")
  return()
endif()
file(REMOVE_RECURSE ${FOLDER})
file(MAKE_DIRECTORY ${FOLDER})

function(must)
  execute_process(COMMAND ${ARGV} WORKING_DIRECTORY ${FOLDER} RESULT_VARIABLE status
    OUTPUT_QUIET ERROR_VARIABLE error)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${ARGV}: ${error}")
  endif()
endfunction()
must(${PROGRAM} tune lua/scenes/paper.lua -n 1000,2000 --set world=20 --variants auto --trials 65 --profile p.db)
must(${PROGRAM} bench --quick --repeat 2 -o bench.json)
must(${PROGRAM} report --profile p.db -o report.html bench.json bench.json)

file(READ ${FOLDER}/report.html page)
file(READ ${CHECK} check)
string(REPLACE "</body>" "<script>${check}</script></body>" page "${page}")
file(WRITE ${FOLDER}/checked.html "${page}")
file(WRITE ${FOLDER}/frames.html "<body>
<script>addEventListener('message', e => document.body.append('[' + e.data + ']'))</script>
<iframe src='checked.html' style='width:390px;height:4000px;border:0'></iframe>
<iframe src='checked.html' style='width:1280px;height:4000px;border:0'></iframe></body>")
execute_process(
  COMMAND ${BROWSER} --headless --no-sandbox --disable-gpu --user-data-dir=${FOLDER}/browser
    --virtual-time-budget=20000 --dump-dom file://${FOLDER}/frames.html
  OUTPUT_VARIABLE seen ERROR_QUIET TIMEOUT 120)
foreach(width 390 1280)
  if(NOT seen MATCHES "\\[${width} wide: [0-9]+ charts are right\\]")
    message(FATAL_ERROR "the report, ${width} pixels wide: ${seen}")
  endif()
endforeach()
