/* What Python hands over, checked: buffers of arrays, held as long as a call goes on. */

#ifndef TENDON_ARGUMENTS_H
#define TENDON_ARGUMENTS_H

#include <string.h>

#include "arrays.h"

#define NAME(name) #name,
static const char *const given_names[] = {GIVEN(NAME)};
static const char *const result_names[] = {RESULTS(NAME)};
static const char *const extreme_names[] = {EXTREMES(NAME)};
static const char *const bound_names[] = {BOUNDS(NAME)};
static const char *const form_names[] = {FORM(NAME)};
static const char *const end_names[] = {WINDOW(NAME)};

#define MOST_HELD (LIMITED + COLUMNS + ACCUMULATORS + 2 * MOST_AXES)

/* Buffers that are read or written until the call is over. */
typedef struct {
    Py_buffer view[MOST_HELD];
    int count;
} Held;

/* The buffer of an array of some bytes a value, or of any (0); null, with an exception, where it is something else. */
static const Py_buffer *hold(Held *held, PyObject *array, const char *name, int writable, long bytes) {
    int flags = PyBUF_STRIDES | (writable ? PyBUF_WRITABLE : 0);
    if (held->count == MOST_HELD) {
        PyErr_SetString(PyExc_ValueError, "more arrays than there is room for");
        return NULL;
    }
    Py_buffer *view = held->view + held->count;
    if (PyObject_GetBuffer(array, view, flags)) return NULL;
    held->count++;
    if (bytes && view->itemsize != bytes) {
        PyErr_Format(PyExc_ValueError, "%s has values of %zd bytes, expected %ld", name, view->itemsize, bytes);
        return NULL;
    }
    return view;
}

/* An input over all axes: the last ones that it has, each as long as the states' or broadcast, angles side by side; or a
 * result over the axes of designs, as long as each. */
static const Py_buffer *take(Array *to, Held *held, PyObject *array, const char *name, const Walk *walk, long bytes,
                             int result) {
    const Py_buffer *view = hold(held, array, name, result, bytes);
    if (!view) return NULL;
    long missing = walk->axes - 2 * result - view->ndim;
    int fits = result ? missing == 0 : missing >= 0;
    to->at = view->buf;
    memset(to->step, 0, sizeof to->step);
    for (long axis = 0; fits && axis < view->ndim; axis++) {
        fits = view->shape[axis] == walk->length[missing + axis] || (!result && view->shape[axis] == 1);
        if (view->shape[axis] > 1) to->step[missing + axis] = (long)view->strides[axis];
    }
    long step = to->step[walk->axes - 1];
    if (fits && (step == 0 || step == view->itemsize)) return view;
    PyErr_Format(PyExc_ValueError, "%s has another shape than the states, or its angles lie apart", name);
    return NULL;
}

/* Inputs, or results, by their names. */
static int take_all(Array *to, Held *held, PyObject *arrays, const char *const *names, int count, const Walk *walk,
                    int results) {
    for (int i = 0; i < count; i++) {
        PyObject *array = PyDict_GetItemString(arrays, names[i]); /* borrowed */
        if (!array) PyErr_Format(PyExc_KeyError, "%s", names[i]);
        if (!array || !take(to + i, held, array, names[i], walk, 8, results)) return 0;
    }
    return 1;
}

/* What every call begins with: the lengths of the axes, and the inputs. */
static int begin(Walk *walk, Array *arrays, Held *held, PyObject *shape, PyObject *given) {
    Py_ssize_t axes = PyTuple_Size(shape);
    if (axes < 2 || axes > MOST_AXES) {
        PyErr_Format(PyExc_ValueError, "states have %zd axes, expected 2 to %d", axes, MOST_AXES);
        return 0;
    }
    memset(walk, 0, sizeof *walk);
    walk->axes = (long)axes;
    for (Py_ssize_t axis = 0; axis < axes; axis++) {
        walk->length[axis] = PyLong_AsLong(PyTuple_GetItem(shape, axis));
        if (walk->length[axis] < 1) {
            if (!PyErr_Occurred()) PyErr_SetString(PyExc_ValueError, "an axis is empty");
            return 0;
        }
    }
    return take_all(arrays, held, given, given_names, INPUTS, walk, 0);
}

/* And ends with: the work, without Python's lock; none where something was wrong. */
static PyObject *finish(Held *held, void (*work)(void *what), void *what) {
    if (work) {
        Py_BEGIN_ALLOW_THREADS
        work(what);
        Py_END_ALLOW_THREADS
    }
    while (held->count) PyBuffer_Release(held->view + --held->count);
    if (!work) return NULL;
    Py_RETURN_NONE;
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

#endif
