/* The extension module: arrays from Python, checked, to the code for a kind of processor, without Python's lock. */

#define PY_SSIZE_T_CLEAN
#define Py_LIMITED_API 0x030b0000
#include <Python.h>

#include <string.h>

#include "arrays.h"
#include "processors.h"

#define DECLARE(kind)                                                                                                  \
    void tendon_extremes_##kind(Extremes *what);                                                                       \
    void tendon_rows_##kind(Rows *what);                                                                               \
    void tendon_window_##kind(Window *what);
DECLARE(plain)
#if CHOICE
DECLARE(avx2)
DECLARE(avx512)
#endif

typedef struct {
    const char *name;
    void (*extremes)(Extremes *what);
    void (*rows)(Rows *what);
    void (*window)(Window *what);
} Kind;

#define OF(kind) {#kind, tendon_extremes_##kind, tendon_rows_##kind, tendon_window_##kind}

/* The kinds of code that this processor can run, the fastest last. */
static int kinds(Kind *found) {
    int count = 0;
    found[count++] = (Kind)OF(plain);
#if CHOICE
    if (__builtin_cpu_supports("avx2")) found[count++] = (Kind)OF(avx2);
    if (__builtin_cpu_supports("avx512f")) found[count++] = (Kind)OF(avx512);
#endif
    return count;
}

static const Kind *kind_of(const char *name) {
    static Kind found[3];
    for (int count = kinds(found), i = 0; i < count; i++)
        if (!strcmp(found[i].name, name)) return found + i;
    PyErr_Format(PyExc_ValueError, "this processor has no code named %s", name);
    return NULL;
}

#define NAME(name) #name,
static const char *const given_names[] = {GIVEN(NAME)};
static const char *const result_names[] = {RESULTS(NAME)};
static const char *const extreme_names[] = {EXTREMES(NAME)};
static const char *const bound_names[] = {BOUNDS(NAME)};
static const char *const end_names[] = {WINDOW(NAME)};

#define MOST_HELD (LIMITED + COLUMNS + ACCUMULATORS + 2 * MOST_AXES)

/* Buffers that are read or written until the call is over. */
typedef struct {
    Py_buffer view[MOST_HELD];
    int count;
} Held;

static void let_go(Held *held) {
    while (held->count) PyBuffer_Release(held->view + --held->count);
}

/* The buffer of an array of some bytes a value; null, with an exception, where it is something else. */
static const Py_buffer *hold(Held *held, PyObject *array, const char *name, int writable, long bytes) {
    int flags = PyBUF_STRIDES | (writable ? PyBUF_WRITABLE : 0);
    if (held->count == MOST_HELD) {
        PyErr_SetString(PyExc_ValueError, "more arrays than there is room for");
        return NULL;
    }
    Py_buffer *view = held->view + held->count;
    if (PyObject_GetBuffer(array, view, flags)) return NULL;
    held->count++;
    if (view->itemsize != bytes) {
        PyErr_Format(PyExc_ValueError, "%s has values of %zd bytes, expected %ld", name, view->itemsize, bytes);
        return NULL;
    }
    return view;
}

/* An array over all axes, of the length of each, or of one where it is broadcast; angles side by side. */
static int over_axes(Array *to, Held *held, PyObject *array, const char *name, const Walk *walk, int writable, long bytes,
                     int whole) {
    const Py_buffer *view = hold(held, array, name, writable, bytes);
    if (!view) return 0;
    long axes = whole ? walk->axes : walk->axes - 2;
    int fits = view->ndim == axes;
    to->at = view->buf;
    memset(to->step, 0, sizeof to->step);
    for (long axis = 0; fits && axis < axes; axis++) {
        fits = view->shape[axis] == walk->length[axis];
        to->step[axis] = view->shape[axis] > 1 ? (long)view->strides[axis] : 0;
    }
    if (fits && whole && walk->length[axes - 1] == 1) to->step[axes - 1] = bytes;
    if (fits && whole) fits = to->step[axes - 1] == 0 || to->step[axes - 1] == bytes;
    if (!fits) PyErr_Format(PyExc_ValueError, "%s has another shape than the states, or its angles lie apart", name);
    return fits;
}

static PyObject *found_in(PyObject *arrays, const char *name) {
    PyObject *array = PyDict_GetItemString(arrays, name); /* borrowed */
    if (!array) PyErr_Format(PyExc_KeyError, "%s", name);
    return array;
}

/* The inputs, and the lengths of the axes as the first of them has them. */
static int set_out(Walk *walk, Array *arrays, Held *held, PyObject *given) {
    PyObject *first = found_in(given, given_names[0]);
    const Py_buffer *view = first ? hold(held, first, given_names[0], 0, 8) : NULL;
    if (!view) return 0;
    if (view->ndim < 2 || view->ndim > MOST_AXES) {
        PyErr_Format(PyExc_ValueError, "states have %d axes, expected 2 to %d", view->ndim, MOST_AXES);
        return 0;
    }
    walk->axes = view->ndim;
    for (int axis = 0; axis < view->ndim; axis++) {
        walk->length[axis] = (long)view->shape[axis];
        if (walk->length[axis] < 1) {
            PyErr_SetString(PyExc_ValueError, "an axis is empty");
            return 0;
        }
    }
    for (int i = 0; i < INPUTS; i++) {
        PyObject *array = found_in(given, given_names[i]);
        if (!array || !over_axes(arrays + i, held, array, given_names[i], walk, 0, 8, 1)) return 0;
    }
    return 1;
}

/* A column of as many rows as are written, one after the other. */
static char *column(Held *held, PyObject *array, const char *name, long rows, long bytes) {
    const Py_buffer *view = hold(held, array, name, 1, bytes);
    if (!view) return NULL;
    if (view->ndim != 1 || view->shape[0] != rows || (rows > 1 && view->strides[0] != bytes)) {
        PyErr_Format(PyExc_ValueError, "%s is not a column of %ld rows", name, rows);
        return NULL;
    }
    return view->buf;
}

static int set_columns(Rows *what, Held *held, PyObject *keys, PyObject *columns) {
    PyObject *name, *from, *to;
    Py_ssize_t place = 0;
    for (int i = 0; i < COLUMNS; i++)
        if ((to = PyDict_GetItemString(columns, result_names[i])))
            if (!(what->column[i] = (double *)column(held, to, result_names[i], what->count, 8))) return 0;
    if ((to = PyDict_GetItemString(columns, "status")))
        if (!(what->status = (int *)column(held, to, "status", what->count, 4))) return 0;
    while (PyDict_Next(keys, &place, &name, &from)) {
        Py_buffer width;
        if (what->keys == MOST_AXES) {
            PyErr_SetString(PyExc_ValueError, "more keys than there is room for");
            return 0;
        }
        if (!(to = PyDict_GetItemWithError(columns, name)) || PyObject_GetBuffer(from, &width, PyBUF_STRIDES)) {
            if (!PyErr_Occurred()) PyErr_SetObject(PyExc_KeyError, name);
            return 0;
        }
        Key *key = what->key + what->keys;
        key->bytes = (long)width.itemsize;
        PyBuffer_Release(&width);
        if (!over_axes(what->arrays + INPUTS + what->keys, held, from, "a key", &what->walk, 0, key->bytes, 1)) return 0;
        if (!(key->to = column(held, to, "a key", what->count, key->bytes))) return 0;
        what->keys++;
    }
    return 1;
}

/* rows(kind, given, keys, columns, first, count): write some rows into columns of that many. */
static PyObject *call_rows(PyObject *self, PyObject *args) {
    const char *name;
    PyObject *given, *keys, *columns;
    static _Thread_local Rows what;
    static _Thread_local Held held;
    memset(&what, 0, sizeof what), held.count = 0;
    if (!PyArg_ParseTuple(args, "sO!O!O!ll", &name, &PyDict_Type, &given, &PyDict_Type, &keys, &PyDict_Type, &columns,
                          &what.first, &what.count))
        return NULL;
    const Kind *kind = kind_of(name);
    int ready = kind && set_out(&what.walk, what.arrays, &held, given) && set_columns(&what, &held, keys, columns);
    if (ready) {
        long states = 1;
        for (long axis = 0; axis < what.walk.axes; axis++) states *= what.walk.length[axis];
        ready = what.first >= 0 && what.count >= 0 && what.first <= states - what.count;
        if (!ready) PyErr_SetString(PyExc_ValueError, "there are no such rows");
    }
    if (ready) {
        Py_BEGIN_ALLOW_THREADS
        if (what.count) kind->rows(&what);
        Py_END_ALLOW_THREADS
    }
    let_go(&held);
    if (!ready) return NULL;
    Py_RETURN_NONE;
}

/* extremes(kind, given, angle, found, pretensions): fold all states into the arrays of `found`, over designs alone.
 * Nothing but pretension depends on the axis `pretensions`; -1 for none. */
static PyObject *call_extremes(PyObject *self, PyObject *args) {
    const char *name;
    PyObject *given, *angle, *found;
    static _Thread_local Extremes what;
    static _Thread_local Held held;
    memset(&what, 0, sizeof what), held.count = 0;
    if (!PyArg_ParseTuple(args, "sO!OO!", &name, &PyDict_Type, &given, &angle, &PyDict_Type, &found))
        return NULL;
    const Kind *kind = kind_of(name);
    int ready = kind && set_out(&what.walk, what.arrays, &held, given);
    for (int i = 0; ready && i < ACCUMULATORS; i++) {
        PyObject *array = found_in(found, extreme_names[i]);
        ready = array && over_axes(what.arrays + INPUTS + i, &held, array, extreme_names[i], &what.walk, 1, 8, 0);
    }
    if (ready) {
        const Py_buffer *view = hold(&held, angle, "angle", 0, 8);
        long angles = what.walk.length[what.walk.axes - 1];
        ready = view && view->ndim == 1 && view->shape[0] == angles && (angles == 1 || view->strides[0] == 8);
        if (ready) what.angle = view->buf;
        else if (!PyErr_Occurred()) PyErr_SetString(PyExc_ValueError, "other angles than the states have, or no such axis");
    }
    if (ready) {
        Py_BEGIN_ALLOW_THREADS
        kind->extremes(&what);
        Py_END_ALLOW_THREADS
    }
    let_go(&held);
    if (!ready) return NULL;
    Py_RETURN_NONE;
}

/* window(kind, given, bounds, found, first, total): fold all states into the arrays of `found`, over designs alone; the
 * angles are those from `first` on of `total`. */
static PyObject *call_window(PyObject *self, PyObject *args) {
    const char *name;
    PyObject *given, *bounds, *found;
    static _Thread_local Window what;
    static _Thread_local Held held;
    memset(&what, 0, sizeof what), held.count = 0;
    if (!PyArg_ParseTuple(args, "sO!O!O!ll", &name, &PyDict_Type, &given, &PyDict_Type, &bounds, &PyDict_Type, &found,
                          &what.first, &what.total))
        return NULL;
    const Kind *kind = kind_of(name);
    int ready = kind && set_out(&what.walk, what.arrays, &held, given);
    for (int i = 0; ready && i < LIMITED - INPUTS; i++) {
        PyObject *array = found_in(bounds, bound_names[i]);
        ready = array && over_axes(what.arrays + INPUTS + i, &held, array, bound_names[i], &what.walk, 0, 8, 1);
    }
    for (int i = 0; ready && i < ENDS; i++) {
        PyObject *array = found_in(found, end_names[i]);
        ready = array && over_axes(what.arrays + LIMITED + i, &held, array, end_names[i], &what.walk, 1, 8, 0);
    }
    if (ready) {
        Py_BEGIN_ALLOW_THREADS
        kind->window(&what);
        Py_END_ALLOW_THREADS
    }
    let_go(&held);
    if (!ready) return NULL;
    Py_RETURN_NONE;
}

/* kinds(): the kinds of code that this processor can run, the fastest last. */
static PyObject *call_kinds(PyObject *self, PyObject *none) {
    Kind found[3];
    int count = kinds(found);
    PyObject *names = PyTuple_New(count);
    for (int i = 0; names && i < count; i++) PyTuple_SetItem(names, i, PyUnicode_FromString(found[i].name));
    return names;
}

static PyMethodDef methods[] = {
    {"rows", call_rows, METH_VARARGS, "rows(kind, given, keys, columns, first, count)"},
    {"extremes", call_extremes, METH_VARARGS, "extremes(kind, given, angle, found, pretensions)"},
    {"window", call_window, METH_VARARGS, "window(kind, given, bounds, found, first, total)"},
    {"kinds", call_kinds, METH_NOARGS, "kinds()"},
    {NULL, NULL, 0, NULL},
};

static int on_import(PyObject *module) { return PyModule_AddIntConstant(module, "version", KERNEL_VERSION); }

static PyModuleDef_Slot slots[] = {{Py_mod_exec, (void *)on_import}, {0, NULL}};

static PyModuleDef definition = {
    .m_base = PyModuleDef_HEAD_INIT, .m_name = "_native", .m_size = 0, .m_methods = methods, .m_slots = slots,
};

PyMODINIT_FUNC PyInit__native(void) { return PyModuleDef_Init(&definition); }
