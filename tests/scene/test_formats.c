// SPDX-License-Identifier: MIT
#include "support/scene_file.h"
#include "support/test.h"

#include "base/text.h"

// Reads the document's blocks ```kind ... ``` as files; returns how many.
static int read_examples(const char *document, const char *kind)
{
    char begin[16];
    char name[64];
    snprintf(begin, sizeof begin, "```%s\n", kind);
    snprintf(name, sizeof name, "test_formats.%s", kind);
    int n = 0;
    const char *at = document;
    while ((at = strstr(at, begin))) {
        at += strlen(begin);
        const char *end = strstr(at, "```");
        duet_scene *scene = must(scene_from_bytes(name, at, (size_t)(end - at), NULL, 0, ERR));
        assert_true(duet_scene_get_info(scene)->n > 1);
        at = end + 3;
        ++n;
    }
    return n;
}

TEST(the_documents_examples_are_read)
{
    char path[512];
    snprintf(path, sizeof path, "%s/../../docs/formats.md", getenv("DUET_TEST_SCENES"));
    own(text) document = test_read_file(path);
    assert_int_equal(read_examples(document.chars, "csv"), 1);
    assert_int_equal(read_examples(document.chars, "lua"), 6);
}

TEST_MAIN(NULL, NULL)
