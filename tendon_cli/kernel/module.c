/* The extension module: arrays from Python, checked, to the code for a kind of processor, without Python's lock. */

#define PY_SSIZE_T_CLEAN
#define Py_LIMITED_API 0x030b0000
#include <Python.h>

#include "arguments.h"

#define DECLARE(kind)                        \
    void tendon_extremes_##kind(void *what); \
    void tendon_rows_##kind(void *what);     \
    void tendon_window_##kind(void *what);
DECLARE(plain)
#if CHOICE
DECLARE(avx2)
DECLARE(avx512)
#endif

typedef struct {
    const char *name;
    void (*extremes)(void *what), (*rows)(void *what), (*window)(void *what);
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

static int set_columns(Rows *what, Held *held, PyObject *keys, PyObject *columns) {
    PyObject *name, *from, *to;
    Py_ssize_t place = 0;
    for (int i = 0; i < COLUMNS; i++)
        if ((to = PyDict_GetItemString(columns, result_names[i])))
            if (!(what->column[i] = (double *)column(held, to, result_names[i], what->count, 8))) return 0;
    if ((to = PyDict_GetItemString(columns, "status")))
        if (!(what->status = (signed char *)column(held, to, "status", what->count, 1))) return 0;
    while (PyDict_Next(keys, &place, &name, &from)) {
        if (what->keys == MOST_AXES) {
            PyErr_SetString(PyExc_ValueError, "more keys than there is room for");
            return 0;
        }
        if (!(to = PyDict_GetItemWithError(columns, name))) {
            if (!PyErr_Occurred()) PyErr_SetObject(PyExc_KeyError, name);
            return 0;
        }
        Key *key = what->key + what->keys;
        const Py_buffer *view = take(what->arrays + INPUTS + what->keys++, held, from, "a key", &what->walk, 0, 0);
        if (!view) return 0;
        key->bytes = (long)view->itemsize;
        if (!(key->to = column(held, to, "a key", what->count, key->bytes))) return 0;
    }
    return 1;
}

/* The names of the columns in which something is not a number. */
static PyObject *without_number(const Rows *what) {
    PyObject *names = PyList_New(0);
    for (int i = 0; names && i < COLUMNS; i++) {
        PyObject *name = what->no_number[i] ? PyUnicode_FromString(result_names[i]) : NULL;
        if (what->no_number[i] && (!name || PyList_Append(names, name))) Py_CLEAR(names);
        Py_XDECREF(name);
    }
    return names;
}

/* rows(kind, shape, given, keys, columns, first, count): write some rows into columns of that many; returns the names of
 * results that are not everywhere a number. */
static PyObject *call_rows(PyObject *self, PyObject *args) {
    const char *name;
    PyObject *shape, *given, *keys, *columns;
    static _Thread_local Rows what;
    static _Thread_local Held held;
    memset(&what, 0, sizeof what);
    if (!PyArg_ParseTuple(args, "sO!O!O!O!ll", &name, &PyTuple_Type, &shape, &PyDict_Type, &given, &PyDict_Type, &keys,
                          &PyDict_Type, &columns, &what.first, &what.count))
        return NULL;
    const Kind *kind = kind_of(name);
    int ready = kind && begin(&what.walk, what.arrays, &held, shape, given) &&
                set_columns(&what, &held, keys, columns);
    if (ready) {
        long states = 1;
        for (long axis = 0; axis < what.walk.axes; axis++) states *= what.walk.length[axis];
        ready = what.first >= 0 && what.count >= 0 && what.first <= states - what.count;
        if (!ready) PyErr_SetString(PyExc_ValueError, "there are no such rows");
    }
    PyObject *done = finish(&held, ready ? kind->rows : NULL, &what);
    if (!done) return NULL;
    Py_DECREF(done);
    return without_number(&what);
}

/* extremes(kind, shape, given, angle, found): fold all states into the arrays of `found`, over designs alone. */
static PyObject *call_extremes(PyObject *self, PyObject *args) {
    const char *name;
    PyObject *shape, *given, *angle, *found;
    static _Thread_local Extremes what;
    static _Thread_local Held held;
    if (!PyArg_ParseTuple(args, "sO!O!OO!", &name, &PyTuple_Type, &shape, &PyDict_Type, &given, &angle, &PyDict_Type,
                          &found))
        return NULL;
    const Kind *kind = kind_of(name);
    int ready = kind && begin(&what.walk, what.arrays, &held, shape, given) &&
                take(&what.angle, &held, angle, "angle", &what.walk, 8, 0) &&
                take_all(what.arrays + INPUTS, &held, found, extreme_names, ACCUMULATORS, &what.walk, 1);
    return finish(&held, ready ? kind->extremes : NULL, &what);
}

/* Forms, a dictionary each, after the bounds; returns zero, with an exception, where something is wrong. */
static int take_forms(Window *what, Held *held, PyObject *forms) {
    Py_ssize_t count = PyTuple_Size(forms);
    if (count > MOST_FORMS) {
        PyErr_SetString(PyExc_ValueError, "more forms than there is room for");
        return 0;
    }
    for (what->forms = 0; what->forms < count; what->forms++) {
        PyObject *form = PyTuple_GetItem(forms, what->forms); /* borrowed */
        if (!PyDict_Check(form)) {
            PyErr_SetString(PyExc_TypeError, "a form is a dictionary of arrays");
            return 0;
        }
        Array *to = what->arrays + BOUNDED + PER_FORM * what->forms;
        if (!take_all(to, held, form, form_names, PER_FORM, &what->walk, 0)) return 0;
    }
    return 1;
}

/* window(kind, shape, given, bounds, forms, found, first, total): fold all states into the arrays of `found`, over
 * designs alone; the angles are those from `first` on of `total`. */
static PyObject *call_window(PyObject *self, PyObject *args) {
    const char *name;
    PyObject *shape, *given, *bounds, *forms, *found;
    static _Thread_local Window what;
    static _Thread_local Held held;
    if (!PyArg_ParseTuple(args, "sO!O!O!O!O!ll", &name, &PyTuple_Type, &shape, &PyDict_Type, &given, &PyDict_Type,
                          &bounds, &PyTuple_Type, &forms, &PyDict_Type, &found, &what.first, &what.total))
        return NULL;
    const Kind *kind = kind_of(name);
    int ready = kind && begin(&what.walk, what.arrays, &held, shape, given) &&
                take_all(what.arrays + INPUTS, &held, bounds, bound_names, BOUNDED - INPUTS, &what.walk, 0) &&
                take_forms(&what, &held, forms) &&
                take_all(what.arrays + BOUNDED + PER_FORM * what.forms, &held, found, end_names, ENDS, &what.walk, 1);
    return finish(&held, ready ? kind->window : NULL, &what);
}

/* results(): the names of the columns of states that are written here. */
static PyObject *call_results(PyObject *self, PyObject *none) {
    PyObject *names = PyTuple_New(COLUMNS);
    for (int i = 0; names && i < COLUMNS; i++) PyTuple_SetItem(names, i, PyUnicode_FromString(result_names[i]));
    return names;
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
    {"rows", call_rows, METH_VARARGS, "rows(kind, shape, given, keys, columns, first, count)"},
    {"extremes", call_extremes, METH_VARARGS, "extremes(kind, shape, given, angle, found)"},
    {"window", call_window, METH_VARARGS, "window(kind, shape, given, bounds, forms, found, first, total)"},
    {"kinds", call_kinds, METH_NOARGS, "kinds()"},
    {"results", call_results, METH_NOARGS, "results()"},
    {NULL, NULL, 0, NULL},
};

static int on_import(PyObject *module) { return PyModule_AddIntConstant(module, "version", KERNEL_VERSION); }

static PyModuleDef_Slot slots[] = {{Py_mod_exec, (void *)on_import}, {0, NULL}};

static PyModuleDef definition = {
    .m_base = PyModuleDef_HEAD_INIT, .m_name = "_native", .m_size = 0, .m_methods = methods, .m_slots = slots,
};

PyMODINIT_FUNC PyInit__native(void) { return PyModuleDef_Init(&definition); }
