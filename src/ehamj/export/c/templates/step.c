/* Let every law that is due compute, and the stage beside them. */
static void sample(ehamj_law_t *law, real_t share)
{
    bool any = false;
    uint32_t k;
    for (k = 0U; k < (uint32_t)LAWS; k++) {
        if (law->until[k] == 0U) {
            any = true;
            compute(law, k);
        }
    }
    if (any) {
        uint32_t i;
        for (i = 0U; i < (uint32_t)VALVES; i++) {
            law->total[i] = R(0.0);
            for (k = 0U; k < (uint32_t)LAWS; k++) {
                law->total[i] += law->latest[k][i];
            }
{% if not staged %}
            law->lost[i] = converted(share * law->total[i], LIMIT, R(0.0)) - law->total[i];
{% endif %}
        }
{% if staged %}
        linearised(law, share, law->until[ROWS - 1] == 0U);
{% endif %}
        for (k = 0U; k < (uint32_t)LAWS; k++) {
            if (law->until[k] == 0U) {
                real_t volts[VALVES];
{% if lines %}
                turn(law, &LAW[k]);
{% endif %}
                advance(law, k);
{% if lines %}
                follow(law, &LAW[k], share);
{% endif %}
                for (i = 0U; i < (uint32_t)VALVES; i++) {
                    volts[i] = share * law->latest[k][i];
                }
                queue(law, k, volts);
            }
        }
    }
{% if fed %}
    if (law->until[{{ fed_row }}] == 0U) {
        feed_back(law, share);
    }
{% endif %}
}

void ehamj_law_init(ehamj_law_t *law)
{
    uint32_t k;
{% if staged or lines %}
    uint32_t i;
{% endif %}
    *law = (ehamj_law_t){.tick = 0U}; /* all else is zero too */
    for (k = 0U; k < (uint32_t)ROWS; k++) {
        law->due[k] = ROW[k].delay;
    }
{% if lines %}
    for (i = 0U; i < (uint32_t)EHAMJ_LAW_LINES; i++) {
        law->hertz[i] = LINE[i].nominal;
    }
{% endif %}
{% if staged %}
    for (i = 0U; i < (uint32_t)VALVES; i++) {
        law->stage[i].level = R({{ level | number }});
{% if learns %}
        law->known[i] = KNOWN[i];
{% for (name, _), value in zip(types.Learnt, stated) %}
        law->learnt[i].{{ name }} = R({{ value | number }});
{% endfor %}
        law->gathered[i].frozen = PACED[i].settling;
{% endif %}
    }
{% endif %}
}

void ehamj_law_rest(ehamj_law_t *law, const ehamj_real_t readings[EHAMJ_LAW_READINGS])
{
{% if counted_from_rest %}
    uint32_t k;
    for (k = 0U; k < {{ counted_from_rest | length }}U; k++) {
        law->rest[FROM_REST[k]] = readings[FROM_REST[k]];
    }
{% else %}
    (void)law; /* no reading counts from rest */
    (void)readings;
{% endif %}
}

void ehamj_law_step(ehamj_law_t *law, const ehamj_real_t readings[EHAMJ_LAW_READINGS],
                    ehamj_real_t commands[EHAMJ_LAW_VALVES])
{
    const real_t share = faded(law);
    uint32_t i;
    uint32_t k;
    for (i = 0U; i < (uint32_t)READINGS; i++) {
        law->readings[i] = readings[i] - law->rest[i];
    }
{% if clock.at_once %}
    release(law);
    sample(law, share);
{% else %}
    sample(law, share);
    release(law);
{% endif %}
    for (i = 0U; i < (uint32_t)VALVES; i++) {
        law->volts[i] = R(0.0);
        for (k = 0U; k < (uint32_t)ROWS; k++) {
            law->volts[i] += law->held[k][i];
        }
        commands[i] = converted(law->volts[i], LIMIT, RESOLUTION);
    }
    for (k = 0U; k < (uint32_t)ROWS; k++) {
        law->until[k] = (law->until[k] == 0U) ? (ROW[k].every - 1U) : (law->until[k] - 1U);
    }
{% if fade.ends %}
    if (law->tick < {{ fade.ends }}U) {
        law->tick++;
    }
{% endif %}
}
