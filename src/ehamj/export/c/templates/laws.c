/* result += matrix vector, row by row. */
static void add_rows(const matrix_t *matrix, const real_t vector[], real_t result[])
{
    uint32_t i;
    uint32_t k;
    for (i = 0U; i < matrix->rows; i++) {
        real_t sum = result[i];
        if (matrix->column == NULL) {
            const real_t *number = &matrix->number[i * matrix->columns];
            for (k = 0U; k < matrix->columns; k++) {
                sum += number[k] * vector[k];
            }
        } else {
            for (k = matrix->begin[i]; k < matrix->begin[i + 1U]; k++) {
                sum += matrix->number[k] * vector[matrix->column[k]];
            }
        }
        result[i] = sum;
    }
}

/* Share of the commands that reaches the valves: 0 before they set in, then 3s^2 - 2s^3 over the fade. */
static real_t faded(const ehamj_law_t *law)
{
{% if not fade.ends %}
    (void)law;
    return R(1.0);
{% else %}
    real_t share = R(1.0);
{% if fade.begins %}
    if (law->tick < {{ fade.begins }}U) {
        share = R(0.0);
    } else{{ " " }}
{%- else %}
    {{ "" }}
{%- endif %}
if (law->tick < {{ fade.ends }}U) {
        const real_t since = (((real_t)law->tick * R({{ fade.steps | number }})) * R({{ fade.timestep | number }})) - R({{ fade.switch_on | number }});
        const real_t s = most(since, R(0.0)) / R({{ fade.fade | number }});
        share = s * s * (R(3.0) - (R(2.0) * s));
    } else {
        /* they have faded in */
    }
    return share;
{% endif %}
}

/* Put the outputs of a row where they wait for their time, or without delay where they are held. */
static void queue(ehamj_law_t *law, uint32_t k, const real_t volts[VALVES])
{
    const row_t *row = &ROW[k];
    real_t *place = law->held[k];
    uint32_t i;
    if (!row->at_once) {
        place = law->ring[row->first + law->put[k]];
        law->put[k] = (law->put[k] + 1U) % row->places;
    }
    for (i = 0U; i < (uint32_t)VALVES; i++) {
        place[i] = volts[i];
    }
}

/* Hand the valves the outputs whose time has come. */
static void release(ehamj_law_t *law)
{
    uint32_t k;
    uint32_t i;
    for (k = 0U; k < (uint32_t)ROWS; k++) {
        const row_t *row = &ROW[k];
        if (row->at_once) {
            continue;
        }
        if (law->due[k] > 0U) {
            law->due[k]--;
        } else {
            const real_t *place = law->ring[row->first + law->got[k]];
            for (i = 0U; i < (uint32_t)VALVES; i++) {
                law->held[k][i] = place[i];
            }
            law->got[k] = (law->got[k] + 1U) % row->places;
            law->due[k] = row->every - 1U;
        }
    }
}

/* What a law reads. */
static void take_inputs(ehamj_law_t *law, const law_t *own)
{
    uint32_t i;
    for (i = 0U; i < own->inputs; i++) {
        law->inputs[i] = law->readings[own->reading[i]];
    }
}

/* y = C x + D u. */
static void compute(ehamj_law_t *law, uint32_t k)
{
    const law_t *own = &LAW[k];
    uint32_t i;
    take_inputs(law, own);
    for (i = 0U; i < (uint32_t)VALVES; i++) {
        law->latest[k][i] = R(0.0);
    }
    add_rows(own->C, &law->states[own->first], law->latest[k]);
    add_rows(own->D, law->inputs, law->latest[k]);
}

/*
 * The states become what A and B have made of them. In single precision that is by how much they change, for between two
 * ticks slow filters hardly do; what a sum loses of it goes into the next.
 */
static void step_states(ehamj_law_t *law, const law_t *own)
{
    real_t *states = &law->states[own->first];
    uint32_t i;
    for (i = 0U; i < own->states; i++) {
#ifdef EHAMJ_LAW_FLOAT
        const real_t change = law->next[i] + law->carry[own->first + i];
        const real_t sum = states[i] + change;
        law->carry[own->first + i] = change - (sum - states[i]);
        states[i] = sum;
#else
        states[i] = law->next[i];
#endif
    }
}

/* x+ = A x + B u + L lost. */
static void advance(ehamj_law_t *law, uint32_t k)
{
    const law_t *own = &LAW[k];
    real_t *states = &law->states[own->first];
    uint32_t i;
    take_inputs(law, own);
    for (i = 0U; i < own->states; i++) {
        law->next[i] = R(0.0);
    }
    add_rows(own->A, states, law->next);
    add_rows(own->B, law->inputs, law->next);
    step_states(law, own);
    if (own->L != NULL) {
        add_rows(own->L, law->lost, states);
    }
}
