# Fetches what package-lock.json names and makes VIEWER and TASK_VIEWER. Without REQUIRED=ON a failure is a warning.
file(REMOVE "${VIEWER}" "${TASK_VIEWER}")
file(MAKE_DIRECTORY "${FOLDER}")
file(COPY ${SOURCES} DESTINATION "${FOLDER}")
get_filename_component(share "${VIEWER}" DIRECTORY)
file(MAKE_DIRECTORY "${share}")
execute_process(
    COMMAND "${NPM}" ci --prefer-offline --no-audit --no-fund --ignore-scripts --loglevel=error
    WORKING_DIRECTORY "${FOLDER}"
    TIMEOUT 120
    RESULT_VARIABLE failed
    OUTPUT_VARIABLE said
    ERROR_VARIABLE said)
if(NOT failed)
    execute_process(
        COMMAND "${NODE}" build.mjs "${VIEWER}" "${TASK_VIEWER}"
        WORKING_DIRECTORY "${FOLDER}"
        RESULT_VARIABLE failed
        OUTPUT_VARIABLE said
        ERROR_VARIABLE said)
endif()
if(failed)
    set(remedy "grasp will write the page of pictures; build again with a network, or set BULLET_CCD_VIEWER=OFF")
    if(REQUIRED STREQUAL "ON")
        message(FATAL_ERROR "The page in three dimensions was not made:\n${said}")
    endif()
    message(WARNING "The page in three dimensions was not made: ${remedy}:\n${said}")
endif()
