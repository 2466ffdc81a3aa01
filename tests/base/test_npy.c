// SPDX-License-Identifier: MIT
#include "support/scene_file.h"
#include "support/test.h"

#include "base/text_file.h"
#include "runtime/scene/scene_load.h"

#define FILE_NAME "test_npy.npy"

// ------------------------------------------------------------ writing .npy

static void add_number(text *t, double value, const char *descr)
{
    bool is_double = descr[2] == '8';
    uint64_t bits = 0;
    uint32_t low = 0;
    float single = (float)value;
    memcpy(&bits, &value, sizeof bits);
    memcpy(&low, &single, sizeof low);
    if (!is_double)
        bits = low;
    int n = is_double ? 8 : 4;
    for (int i = 0; i < n; ++i) {
        int byte = descr[0] == '>' ? n - 1 - i : i;
        text_add_bytes(t, &(char){(char)(bits >> (8 * byte))}, 1);
    }
}

// A header with the literal, padded as NumPy does.
static text npy_begin(int version, const char *literal)
{
    text t = {0};
    size_t start = version == 1 ? 10 : 12;
    size_t length = (start + strlen(literal) + 1 + 63) / 64 * 64 - start;
    text_add_bytes(&t, "\x93NUMPY", 6);
    text_add_bytes(&t, (const char[]){(char)version, 0}, 2);
    for (size_t i = 0; i < start - 8; ++i)
        text_add_bytes(&t, &(char){(char)(length >> (8 * i))}, 1);
    text_add(&t, "%-*s\n", (int)length - 1, literal);
    return t;
}

static text npy_of(int version, const char *descr, bool fortran, const double *rows, uint32_t n,
                   uint32_t columns)
{
    char literal[128];
    snprintf(literal, sizeof literal, "{'descr': '%s', 'fortran_order': %s, 'shape': (%u, %u), }",
             descr, fortran ? "True" : "False", n, columns);
    text t = npy_begin(version, literal);
    for (uint32_t i = 0; i < n * columns; ++i)
        add_number(&t, fortran ? rows[i % n * columns + i / n] : rows[i], descr);
    return t;
}

static duet_scene *read_npy(const text *t, duet_error *err)
{
    return scene_from_bytes(FILE_NAME, t->chars, t->length, NULL, 0, err);
}

static void assert_refused(const text *t, duet_status status, const char *says)
{
    must_fail(read_npy(t, ERR), status, says);
}

// -------------------------------------------------------------------- tests

static const double rows[3 * 10] = {
    0, 1, 2, 0.5, 0.25, 0.125, 0, 0, 0, 1, //
    3, 4, 5, 1,   2,    3,     1, 0, 0, 1, //
    6, 7, 8, 0,   0,    0,     0, 0, 1, 1,
};

TEST(every_version_type_and_order_gives_the_same_objects)
{
    static const char *const descrs[] = {"<f4", "<f8", ">f4", ">f8"};
    for (int version = 1; version <= 3; ++version)
        for (int k = 0; k < 4; ++k)
            for (int fortran = 0; fortran < 2; ++fortran) {
                own(text) t = npy_of(version, descrs[k], fortran, rows, 3, 10);
                duet_scene *scene = must(read_npy(&t, ERR));
                assert_int_equal(duet_scene_get_info(scene)->n, 3);
                for (int i = 0; i < 30; ++i)
                    assert_true(((const float *)duet_scene_get_objects(
                                    scene, DUET_OBJECT_POSES))[i] == (float)rows[i]);
            }
}

// Row by row, and column by column; more rows than are read at once.
TEST(a_range_is_that_part_of_the_whole)
{
    enum { ROWS = 40000, COLUMNS = 6 };
    static const uint64_t ranges[][2] = {{0, ROWS},     {0, 1},        {0, 0}, {16383, 16386},
                                         {30000, ROWS}, {39999, ROWS}, {7, 7}, {5, UINT64_MAX}};
    double *many = test_alloc((size_t)ROWS * COLUMNS * sizeof *many);
    for (int i = 0; i < ROWS * COLUMNS; ++i)
        many[i] = i % COLUMNS < 3 ? i / COLUMNS : i / COLUMNS + i % COLUMNS;
    for (int fortran = 0; fortran < 2; ++fortran) {
        uint64_t n = 0, deferred = 0;
        own(text) t = npy_of(1, "<f8", fortran, many, ROWS, COLUMNS);
        must(text_write_file(FILE_NAME, t.chars, t.length, ERR));
        for (size_t k = 0; k < sizeof ranges / sizeof *ranges; ++k) {
            uint64_t end = ranges[k][1] < ROWS ? ranges[k][1] : ROWS;
            duet_scene *scene =
                kept(scene_load_range(FILE_NAME, NULL, 0, ranges[k][0], ranges[k][1], &n, ERR));
            const duet_bounds *bounds = duet_scene_get_objects(scene, DUET_OBJECT_BOUNDS);
            assert_int_equal(n, ROWS);
            assert_int_equal(duet_scene_get_info(scene)->n, end - ranges[k][0]);
            for (uint64_t i = 0; i < end - ranges[k][0]; ++i) {
                float at = (float)(ranges[k][0] + i);
                assert_true(bounds[i].lower[0] == at && bounds[i].lower[2] == at);
                assert_true(bounds[i].upper[0] == at + 3 && bounds[i].upper[2] == at + 5);
            }
        }
        duet_scene *first = kept(scene_load_deferred(FILE_NAME, NULL, 0, &n, &deferred, ERR));
        assert_int_equal(duet_scene_get_info(first)->n, 1);
        assert_int_equal(n, ROWS);
        assert_int_equal(deferred, ROWS - 1);
    }
}

TEST(the_second_number_of_the_shape_says_what_a_row_is)
{
    static const struct {
        uint32_t columns;
        uint32_t dims;
        duet_shape shape;
    } kinds[] = {{4, 2, DUET_SHAPE_BOUNDS},
                 {5, 2, DUET_SHAPE_POSES},
                 {6, 3, DUET_SHAPE_BOUNDS},
                 {10, 3, DUET_SHAPE_POSES}};
    static const double ascending[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
    for (int i = 0; i < 4; ++i)
        for (uint32_t n = 0; n <= 1; ++n) {
            own(text) t = npy_of(1, "<f4", false, ascending, n, kinds[i].columns);
            duet_scene *scene = must(read_npy(&t, ERR));
            assert_int_equal(duet_scene_get_info(scene)->n, n);
            assert_int_equal(duet_scene_get_info(scene)->dims, kinds[i].dims);
            assert_int_equal(duet_scene_get_info(scene)->shape, kinds[i].shape);
        }
}

TEST(a_double_that_no_float_holds_is_refused)
{
    const double row[] = {0, 0, 0, 1e300};
    own(text) t = npy_of(1, "<f8", false, row, 1, 4);
    assert_refused(&t, DUET_STATUS_BAD_OBJECT,
                   FILE_NAME ": object 0: max y = 1e+300 does not fit a 32-bit float");
}

TEST(a_bad_object_is_refused_by_its_id)
{
    double bad[30];
    memcpy(bad, rows, sizeof bad);
    bad[20 + 4] = -1;
    own(text) t = npy_of(1, ">f4", true, bad, 3, 10);
    assert_refused(&t, DUET_STATUS_BAD_OBJECT, FILE_NAME ": object 2: hy = -1 is negative");
}

TEST(a_wrong_header_is_refused)
{
    static const struct {
        const char *literal;
        duet_status status;
        const char *says;
    } wrong[] = {
        {"{'descr': '<i4', 'fortran_order': False, 'shape': (3, 4), }", DUET_STATUS_BAD_INPUT,
         "the numbers are '<i4'; they must be float32 or float64"},
        {"{'descr': [('x', '<f4')], 'fortran_order': False, 'shape': (3, 4), }",
         DUET_STATUS_BAD_INPUT, "the numbers are records"},
        {"{'descr': '<f4', 'fortran_order': False, 'shape': (3, 8), }", DUET_STATUS_BAD_INPUT,
         "the shape is (3, 8); the second number must be 4, 5, 6, 7, 10 or 11"},
        {"{'descr': '<f4', 'fortran_order': False, 'shape': (12,), }", DUET_STATUS_BAD_INPUT,
         "the array has 1 dimensions; its shape must be (n, columns)"},
        {"{'descr': '<f4', 'fortran_order': False, 'shape': (), }", DUET_STATUS_BAD_INPUT,
         "the array has 0 dimensions"},
        {"{'descr': '<f4', 'fortran_order': False, 'shape': (3, 2, 2), }", DUET_STATUS_BAD_INPUT,
         "the array has 3 dimensions"},
        {"{'descr': '<f4', 'fortran_order': False, 'shape': (4294967294, 4), }",
         DUET_STATUS_TOO_MANY, "4294967294 objects; a scene holds at most 4294967293"},
        {"{'descr': '<f4', 'fortran_order': False, 'shape': (18446744073709551615, 4), }",
         DUET_STATUS_TOO_MANY, "18446744073709551615 objects"},
        {"{'descr': '<f4', 'fortran_order': False, 'shape': (18446744073709551616, 4), }",
         DUET_STATUS_BAD_INPUT, "shape is not a list of numbers"},
        {"{'descr': '<f4', 'fortran_order': False, 'shape': (4294967293, 10), }",
         DUET_STATUS_BAD_INPUT,
         "cut short: the shape (4294967293, 10) needs 171798691720 bytes of data, and 0 follow"},
        {"{'descr': '<f4', 'fortran_order': False, 'shape': (-1, 4), }", DUET_STATUS_BAD_INPUT,
         "shape is not a list of numbers"},
        {"{'descr': '<f4', 'fortran_order': 1, 'shape': (1, 4), }", DUET_STATUS_BAD_INPUT,
         "fortran_order is neither True nor False"},
        {"{'descr': '<f4', 'fortran_order': False, }", DUET_STATUS_BAD_INPUT,
         "lacks descr or shape"},
        {"{'fortran_order': False, 'shape': (1, 4), }", DUET_STATUS_BAD_INPUT,
         "lacks descr or shape"},
        {"{'color': '<f4', 'shape': (1, 4), }", DUET_STATUS_BAD_INPUT, "a key other than descr"},
        {"['descr']", DUET_STATUS_BAD_INPUT, "not a Python dictionary"},
        {"{'descr': '<f4', 'shape': (1, 4)", DUET_STATUS_BAD_INPUT, "not a Python dictionary"},
        {"{'descr': '<f4', 'shape': (0, 4)} x", DUET_STATUS_BAD_INPUT, "not a Python dictionary"},
        {"", DUET_STATUS_BAD_INPUT, "not a Python dictionary"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i) {
        own(text) t = npy_begin(1, wrong[i].literal);
        assert_refused(&t, wrong[i].status, wrong[i].says);
    }
}

TEST(other_files_and_later_versions_are_refused)
{
    scene_assert_refused(FILE_NAME, "1,2,3,4\n", DUET_STATUS_BAD_INPUT, "does not begin as a .npy");
    scene_assert_refused(FILE_NAME, "", DUET_STATUS_BAD_INPUT, "does not begin as a .npy");
    own(text) t = npy_of(4, "<f4", false, rows, 3, 10);
    assert_refused(&t, DUET_STATUS_BAD_INPUT, "is .npy version 4; versions 1, 2 and 3 are read");
}

TEST(every_truncation_is_refused)
{
    for (int version = 1; version <= 2; ++version) {
        own(text) t = npy_of(version, "<f8", false, rows, 3, 10);
        for (size_t n = 0; n < t.length; ++n) {
            char *exact = test_alloc(n ? n : 1); // so that a read past the end is seen
            memcpy(exact, t.chars, n);
            must_fail(scene_from_bytes(FILE_NAME, exact, n, NULL, 0, ERR), DUET_STATUS_BAD_INPUT,
                      "");
        }
    }
}

TEST(bytes_after_the_array_are_refused)
{
    own(text) t = npy_of(1, "<f4", false, rows, 3, 10);
    text_add_bytes(&t, "", 1);
    assert_refused(&t, DUET_STATUS_BAD_INPUT,
                   "too long: the shape (3, 10) needs 120 bytes of data, and 121 follow");
}

TEST(changed_bytes_are_read_or_refused)
{
    rng r = rng_seed(test_seed());
    own(text) good = npy_of(1, "<f4", false, rows, 3, 10);
    for (int round = 0; round < 5000; ++round) {
        own(text) t = {0};
        text_add_bytes(&t, good.chars, good.length);
        for (uint32_t k = 1 + rng_below(&r, 3); k > 0; --k)
            t.chars[rng_below(&r, 80)] = (char)rng_below(&r, 256);
        duet_error err = {0};
        duet_scene *scene = read_npy(&t, &err);
        assert_true((scene != NULL) == (err.status == DUET_STATUS_OK));
        assert_true(scene || (err.text[0] && !strchr(err.text, '\n')));
    }
}
