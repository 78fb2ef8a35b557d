/*
 * Run the controller over the test vectors, vectors.bin, and compare it with the simulation.
 *
 * References and measured positions of each period go in, open loop; what comes out has to agree
 * with what the simulation computed from the same measurements, within a part of full scale: the
 * largest magnitude of the signal in the vectors.
 *
 * vectors.bin: 8 characters "PSRMVEC1", the numbers of rows and of columns, then the rows; all
 * numbers are doubles of this machine's byte order. A row has for each axis x, y what struct
 * vector has.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "psrm_controller.h"

#define SIGNALS 14U

/* One axis in one period */
typedef struct {
    psrm_reference reference;
    double position;
    double signal[SIGNALS];
} vector;

typedef struct {
    const char *name;
    double tolerance; /* of full scale */
    double vanishing; /* difference that is none, however small full scale is */
} signal_kind;

static const double EXACT = 1e-12;
static const double SQUARE = 2e-12; /* of a current: twice as much, relative */
static const double SINGLE = 1.2e-7; /* the simulation records these in single precision */

/* Give the square of a current with its sign. */
static double squared(double current)
{
    return current * fabs(current);
}

/* Read a row for each axis, and square its currents; 0 where the file ends. */
static int read_row(FILE *file, vector row[PSRM_AXES])
{
    uint32_t axis;
    uint32_t i;

    if (fread(row, PSRM_AXES * sizeof row[0], 1U, file) != 1U) {
        return 0;
    }
    for (axis = 0U; axis < PSRM_AXES; axis++) {
        for (i = 0U; i < PSRM_PHASES; i++) {
            row[axis].signal[i] = squared(row[axis].signal[i]);
        }
    }
    return 1;
}

static void describe(signal_kind kind[SIGNALS])
{
    static const char *const NAME[SIGNALS] = {
        "current a squared, A^2", "current b squared, A^2", "current c squared, A^2",
        "force realised, N",      "friction estimate, N",   "K, m/s",
        "disturbance estimate, N", "velocity, m/s",         "following error, m",
        "bristle estimate, m",    "PD force, N",            "force command, N",
        "force saturated",        "current saturated",
    };
    uint32_t i;

    for (i = 0U; i < SIGNALS; i++) {
        kind[i].name = NAME[i];
        kind[i].tolerance = EXACT;
        kind[i].vanishing = 0.0;
    }
    for (i = 0U; i < PSRM_PHASES; i++) {
        kind[i].tolerance = SQUARE;
    }
    for (i = 9U; i <= 11U; i++) {
        kind[i].tolerance = SINGLE;
        kind[i].vanishing = (double)FLT_MIN;
    }
}

/* Give what an axis put out, in the order of the vectors. */
static void collect(const psrm_output *output, uint32_t axis, double signal[SIGNALS])
{
    const psrm_signals *s = &output->axis[axis];

    signal[0] = squared(output->current[axis][0]);
    signal[1] = squared(output->current[axis][1]);
    signal[2] = squared(output->current[axis][2]);
    signal[3] = s->force_realised;
    signal[4] = s->friction_estimate;
    signal[5] = s->K;
    signal[6] = s->disturbance_estimate;
    signal[7] = s->velocity;
    signal[8] = s->following_error;
    signal[9] = s->bristle_estimate;
    signal[10] = s->pd_force;
    signal[11] = s->force_command;
    signal[12] = (double)s->force_saturated;
    signal[13] = (double)s->current_saturated;
}

/* Open the vectors and give the number of rows; NULL where they are none of ours. */
static FILE *open_vectors(const char *path, uint32_t *rows)
{
    char magic[8];
    double size[2];
    FILE *file = fopen(path, "rb");

    if (file == NULL) {
        (void)fprintf(stderr, "%s: cannot be opened\n", path);
        return NULL;
    }
    if ((fread(magic, sizeof magic, 1U, file) != 1U) || (memcmp(magic, "PSRMVEC1", 8U) != 0)
        || (fread(size, sizeof size, 1U, file) != 1U)
        || (size[1] != (double)(PSRM_AXES * sizeof(vector) / sizeof(double)))
        || !(size[0] >= 1.0) || (size[0] > 1e9)) {
        (void)fprintf(stderr, "%s: no test vectors of this controller and byte order\n", path);
        (void)fclose(file);
        return NULL;
    }
    *rows = (uint32_t)size[0];
    return file;
}

/* Give the largest magnitude of each signal; 0 where the file ends early. */
static int full_scale(FILE *file, uint32_t rows, double scale[PSRM_AXES][SIGNALS])
{
    const long start = ftell(file);
    vector row[PSRM_AXES];
    uint32_t k;
    uint32_t axis;
    uint32_t i;

    for (k = 0U; k < rows; k++) {
        if (read_row(file, row) == 0) {
            return 0;
        }
        for (axis = 0U; axis < PSRM_AXES; axis++) {
            for (i = 0U; i < SIGNALS; i++) {
                scale[axis][i] = fmax(scale[axis][i], fabs(row[axis].signal[i]));
            }
        }
    }
    return fseek(file, start, SEEK_SET) == 0;
}

/* Step the controller over all rows; return how many numbers are beyond their tolerance. */
static uint32_t compare(FILE *file, uint32_t rows, double scale[PSRM_AXES][SIGNALS],
                        double largest[PSRM_AXES][SIGNALS])
{
    signal_kind kind[SIGNALS];
    psrm_parameters parameters;
    psrm_state state;
    psrm_output output;
    vector row[PSRM_AXES];
    psrm_reference reference[PSRM_AXES];
    double position[PSRM_AXES];
    double found[SIGNALS];
    double difference;
    double allowed;
    uint32_t failures = 0U;
    uint32_t k;
    uint32_t axis;
    uint32_t i;

    describe(kind);
    psrm_initial_parameters(&parameters);
    psrm_reset(&state);
    for (k = 0U; k < rows; k++) {
        if (read_row(file, row) == 0) {
            return failures + 1U;
        }
        for (axis = 0U; axis < PSRM_AXES; axis++) {
            reference[axis] = row[axis].reference;
            position[axis] = row[axis].position;
        }
        psrm_step(&parameters, &state, reference, position, &output);
        for (axis = 0U; axis < PSRM_AXES; axis++) {
            collect(&output, axis, found);
            for (i = 0U; i < SIGNALS; i++) {
                difference = fabs(found[i] - row[axis].signal[i]);
                largest[axis][i] = fmax(largest[axis][i], difference);
                allowed = (kind[i].tolerance * scale[axis][i]) + kind[i].vanishing;
                if (!(difference <= allowed)) { /* NaN too */
                    if (failures == 0U) {
                        (void)printf("first at %.4f s, axis %c, %s: %.17g, simulated %.17g\n",
                                     (double)k * PSRM_PERIOD, (axis == 0U) ? 'x' : 'y',
                                     kind[i].name, found[i], row[axis].signal[i]);
                    }
                    failures++;
                }
            }
        }
    }
    return failures;
}

static void print_table(double scale[PSRM_AXES][SIGNALS], double largest[PSRM_AXES][SIGNALS])
{
    signal_kind kind[SIGNALS];
    uint32_t axis;
    uint32_t i;

    describe(kind);
    (void)printf("axis  signal                     full scale  difference  of full scale  allowed\n");
    for (axis = 0U; axis < PSRM_AXES; axis++) {
        for (i = 0U; i < SIGNALS; i++) {
            (void)printf("%-4c  %-24s  %11.3e  %10.1e  %13.1e  %7.1e\n", (axis == 0U) ? 'x' : 'y',
                         kind[i].name, scale[axis][i], largest[axis][i],
                         (scale[axis][i] > 0.0) ? (largest[axis][i] / scale[axis][i]) : 0.0,
                         kind[i].tolerance);
        }
    }
}

int main(int argc, char **argv)
{
    double scale[PSRM_AXES][SIGNALS] = {{0.0}};
    double largest[PSRM_AXES][SIGNALS] = {{0.0}};
    uint32_t rows = 0U;
    uint32_t failures;
    FILE *file = open_vectors((argc > 1) ? argv[1] : "vectors.bin", &rows);

    if (file == NULL) {
        return 2;
    }
    if (full_scale(file, rows, scale) == 0) {
        (void)fprintf(stderr, "the vectors end early\n");
        (void)fclose(file);
        return 2;
    }
    failures = compare(file, rows, scale, largest);
    (void)fclose(file);
    print_table(scale, largest);
    (void)printf("%lu periods, %lu numbers beyond their tolerance: %s\n", (unsigned long)rows,
                 (unsigned long)failures, (failures == 0U) ? "passed" : "FAILED");
    return (failures == 0U) ? 0 : 1;
}
