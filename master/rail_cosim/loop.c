/* Macro steps of FMUs: the same calls in the same order as rail_cosim.algorithms makes them, without
 * Python between. What the arrays are: rail_cosim.march. */

#include <math.h>
#include <stdint.h>
#include <string.h>

enum { OK = 0, WARNING = 1, ERROR = 3 };
enum { SET_REAL, DO_STEP, GET_REAL, GET_INTEGER, GET_STRING, DIVERGED };

static const double LARGEST_VALUE = 1e12; /* no exchanged quantity comes near this in SI units */

typedef int (*vector_call)(void *component, const uint32_t *references, size_t count, void *values);
typedef int (*step_call)(void *component, double time, double step_size, int no_rollback);

/* An FMU: its functions, and where the values go that they take and give. */
typedef struct {
    void *component;
    step_call do_step;
    int64_t rolls_back;
    vector_call set_real;
    const uint32_t *inputs;
    int64_t input_count;
    double *input_values;
    const int64_t *sources; /* of the inputs, among the outputs of all FMUs */
    vector_call get_real;
    const uint32_t *outputs;
    int64_t output_count, coupled_count; /* the coupled ones come first */
    double *output_values;
    vector_call get_integer;
    const uint32_t *counters;
    int64_t counter_count;
    int32_t *counter_values;
    vector_call get_string;
    const uint32_t *text; /* the variable outputs.packed */
    int64_t text_count;   /* numbers in it, 0 where there is none */
    double **text_reals;  /* where each goes, NULL for a counter */
    int32_t **text_counters;
} Fmu;

/* What is recorded after a step: columns of reals and counters, and what is watched always. */
typedef struct {
    int64_t every, width, real_count, counter_count, watched_count;
    const double **reals, **watched;
    const int32_t **counters;
    const int64_t *real_columns, *counter_columns;
    double *records, *seen;
} Recording;

/* Where a block of steps ended; a failing FMU is -1 if none failed. */
typedef struct {
    int64_t done, recorded, fmu, call, status;
} End;

static int set_inputs(Fmu *fmu, const double *outputs)
{
    for (int64_t i = 0; i < fmu->input_count; i++)
        fmu->input_values[i] = outputs[fmu->sources[i]];
    if (fmu->input_count == 0)
        return OK;
    return fmu->set_real(fmu->component, fmu->inputs, fmu->input_count, fmu->input_values);
}

static int digit(char c) { return c <= '9' ? c - '0' : c - 'a' + 10; }

/* Read all outputs as one text of float64, little-endian, in hexadecimal digits: to an FMU made with
 * pythonfmu, which hands over Python objects, single values cost four times as much. */
static int read_text(Fmu *fmu)
{
    const char *text = NULL;
    int status = fmu->get_string(fmu->component, fmu->text, 1, &text);
    if (status > WARNING)
        return status;
    if (text == NULL || strnlen(text, 16 * fmu->text_count) < (size_t)(16 * fmu->text_count))
        return ERROR;
    for (int64_t i = 0; i < fmu->text_count; i++, text += 16) {
        uint64_t bits = 0;
        double value;
        for (int byte = 7; byte >= 0; byte--)
            bits = bits << 8 | (uint64_t)(digit(text[2 * byte]) << 4 | digit(text[2 * byte + 1]));
        memcpy(&value, &bits, 8);
        if (fmu->text_reals[i])
            *fmu->text_reals[i] = value;
        else
            *fmu->text_counters[i] = (int32_t)value;
    }
    return status;
}

/* Read the coupled outputs, after a step that is recorded all; say which call failed. */
static int read_outputs(Fmu *fmu, int is_recorded, int64_t *call)
{
    int status = OK;
    if (is_recorded && fmu->text_count > 0) {
        *call = GET_STRING;
        return read_text(fmu);
    }
    int64_t count = is_recorded ? fmu->output_count : fmu->coupled_count;
    *call = GET_REAL;
    if (count > 0)
        status = fmu->get_real(fmu->component, fmu->outputs, count, fmu->output_values);
    if (status > WARNING || !is_recorded || fmu->counter_count == 0)
        return status;
    *call = GET_INTEGER;
    return fmu->get_integer(
        fmu->component, fmu->counters, fmu->counter_count, fmu->counter_values);
}

static int has_diverged(const Fmu *fmu)
{
    for (int64_t i = 0; i < fmu->coupled_count; i++)
        if (!(fabs(fmu->output_values[i]) < LARGEST_VALUE)) /* nor is it with what is no number */
            return 1;
    return 0;
}

static void record(const Recording *to, double time, int is_recorded, int64_t step, End *end)
{
    double *seen = to->seen + step * to->watched_count;
    for (int64_t i = 0; i < to->watched_count; i++)
        seen[i] = *to->watched[i];
    if (!is_recorded)
        return;
    double *row = to->records + end->recorded++ * to->width;
    row[0] = time;
    for (int64_t i = 0; i < to->real_count; i++)
        row[to->real_columns[i]] = *to->reals[i];
    for (int64_t i = 0; i < to->counter_count; i++)
        row[to->counter_columns[i]] = *to->counters[i];
}

/* Do `count` steps after `done`. Sequentially, each FMU gets the newest outputs of those before it
 * (Gauss-Seidel); otherwise all get those of the step before (Jacobi). */
void rail_cosim_steps(Fmu *fmus, int64_t fmu_count, const double *outputs, int64_t done,
                      int64_t count, double step_size, int64_t is_sequential,
                      const Recording *recording, End *end)
{
    *end = (End){done, 0, -1, 0, OK};
    for (int64_t step = done + 1; step <= done + count; step++) {
        double time = (double)(step - 1) * step_size;
        int is_recorded = step % recording->every == 0;
        for (int64_t i = 0; !is_sequential && i < fmu_count; i++) {
            int status = set_inputs(&fmus[i], outputs);
            if (status > WARNING) {
                *end = (End){end->done, end->recorded, i, SET_REAL, status};
                return;
            }
        }
        for (int64_t i = 0; i < fmu_count; i++) {
            Fmu *fmu = &fmus[i];
            int64_t call = SET_REAL;
            int status = is_sequential ? set_inputs(fmu, outputs) : OK;
            if (status <= WARNING) {
                call = DO_STEP;
                status = fmu->do_step(fmu->component, time, step_size, !fmu->rolls_back);
            }
            if (status <= WARNING)
                status = read_outputs(fmu, is_recorded, &call);
            if (status <= WARNING && has_diverged(fmu))
                call = DIVERGED;
            if (status > WARNING || call == DIVERGED) {
                *end = (End){end->done, end->recorded, i, call, status > WARNING ? status : OK};
                return;
            }
        }
        record(recording, (double)step * step_size, is_recorded, step - done - 1, end);
        end->done = step;
    }
}
