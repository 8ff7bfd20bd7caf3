/*
 * {{ title | comment }}
 * {{ made | comment }}
 *
 * Compile it without contracting products and sums (gcc, clang: -ffp-contract=off) to get the simulator's very numbers.
 */
#include "ehamj_law.h"

#include <math.h>
#include <stddef.h>

typedef ehamj_real_t real_t;

/* A constant in the precision of all others. */
#define R(number) ((real_t)(number))
#define LIMIT R(EHAMJ_LAW_LIMIT)
#define RESOLUTION R(EHAMJ_LAW_RESOLUTION)

/* An entry of the diagonal of A, of which single precision keeps what it is more than one (see step_states()). */
#ifdef EHAMJ_LAW_FLOAT
#define DIAGONAL(number, more) R(more)
#else
#define DIAGONAL(number, more) R(number)
#endif

#ifdef EHAMJ_LAW_FLOAT
#define FLOOR floorf
{% if staged %}
#define SQRT sqrtf
#define ABS fabsf
#define COPYSIGN copysignf
#define TINY R(1e-37) /* keeps 0/0 away */
{% endif %}
#else
#define FLOOR floor
{% if staged %}
#define SQRT sqrt
#define ABS fabs
#define COPYSIGN copysign
#define TINY R(1e-300) /* keeps 0/0 away */
{% endif %}
#endif

enum { LAWS = EHAMJ_LAW_LAWS, ROWS = EHAMJ_LAW_ROWS, VALVES = EHAMJ_LAW_VALVES, READINGS = EHAMJ_LAW_READINGS };

static real_t least(real_t one, real_t other)
{
    return (other < one) ? other : one;
}

static real_t most(real_t one, real_t other)
{
    return (other > one) ? other : one;
}

/* What a converter makes of a value: limited to both sides, rounded to its resolution (0: exact). */
static real_t converted(real_t value, real_t limit, real_t resolution)
{
    real_t found = least(most(value, -limit), limit);
    if (resolution > R(0.0)) {
        found = resolution * FLOOR((found / resolution) + R(0.5));
    }
    return found;
}

{% include "tables.c" %}

{% include "laws.c" %}
{% if lines %}

{% include "lines.c" %}
{% endif %}
{% if staged %}

{% include "opening.c" %}
{% if learns %}

{% include "learning.c" %}
{% endif %}

{% include "stage.c" %}
{% endif %}
{% if fed %}

{% include "spools.c" %}
{% endif %}

{% include "step.c" %}
