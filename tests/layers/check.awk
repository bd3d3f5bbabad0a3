# Input: rules.txt, then lines "FILE:LINE:#include ..." of all sources. See rules.txt for what is checked.

BEGIN {
    # C17 and C++17, which any file may include.
    split("assert complex ctype errno fenv float inttypes iso646 limits locale math setjmp signal stdalign stdarg" \
          " stdatomic stdbool stddef stdint stdio stdlib stdnoreturn string tgmath threads time uchar wchar wctype", c, " ")
    for (i in c)
        standard[c[i] ".h"] = 1
    delete standard["signal.h"] # what one does with it is POSIX
}

function fail(what) {
    print file ":" line ": " what
    failed = 1
}

# The room of a file or header, by its path below engine/ or the root: its folder in lightformer/, else the
# top one. A header without a folder has none.
function room_of(path) {
    if (path ~ /^lightformer\//)
        sub(/\/[^\/]*$/, "", path)
    else if (!sub(/\/.*/, "", path))
        return ""
    return path
}

# Whether a room is another, or inside it.
function is_inside(room, other) {
    return index(room "/", other "/") == 1
}

# Whether a header is in a table of names, where a name that ends with "/" stands for all below it.
function listed(table, header,    top) {
    top = header
    sub(/\/.*/, "/", top)
    return (header in table) || (top in table)
}

FILENAME != "-" {
    sub(/#.*/, "")
    if ($1 == "room") {
        sub(/:$/, "", $2)
        room_known[$2] = 1
        may[$2, $2] = 1
        for (i = 3; i <= NF; i++) {
            if (!($i in room_known)) {
                print "rules.txt: " $2 " names " $i ", which is not above it"
                failed = 1
            }
            may[$2, $i] = 1
        }
    }
    for (i = 2; i <= NF; i++) {
        if ($1 == "posix:") posix[$i] = 1
        if ($1 == "posix-rooms:") posix_room[$i] = 1
        if ($1 == "shared:") shared[$i] = 1
        if ($1 == "folder:") in_folder[$i] = 1
        if ($1 == "public:") public[$i] = 1
    }
    next
}

{
    split($0, part, ":")
    file = part[1]
    line = part[2]
    path = file
    sub(/^engine\//, "", path)
    room = room_of(path)
    if (!(room in room_known)) {
        fail("room \"" room "\" is not in rules.txt")
        next
    }
    is_public = file ~ /\.h$/ && file !~ /_internal\.h$/ && file !~ /^(tools|samples)\//
}

match($0, /"[^"]+"/) {
    header = substr($0, RSTART + 1, RLENGTH - 2)
    target = room_of(header)
    if (!(target in room_known) && header !~ /^lightformer\//)
        next # beside the file that includes it, or in a folder below
    if (!((room, target) in may))
        fail(room " may not include " target " (\"" header "\")")
    else if (header ~ /_internal\.h$/ && !is_inside(room, target))
        fail("\"" header "\" belongs to " target " alone")
    next
}

match($0, /<[^>]+>/) {
    header = substr($0, RSTART + 1, RLENGTH - 2)
    if (header in standard || header !~ /[.\/]/)
        next
    if (listed(posix, header)) {
        if (!(room in posix_room))
            fail("POSIX header <" header "> outside of base and app")
        next
    }
    if (is_public && !listed(public, header))
        fail("third-party header <" header "> in a public header")
    if (listed(shared, header))
        next
    library = header
    sub(/\/.*/, "", library)
    one = file
    if (header in in_folder)
        sub(/\/[^\/]*$/, "", one)
    if (library in user && user[library] != one)
        fail("<" header ">: " user[library] " includes this library already; only one file may")
    user[library] = one
}

END {
    exit failed
}
