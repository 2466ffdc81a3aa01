
add()