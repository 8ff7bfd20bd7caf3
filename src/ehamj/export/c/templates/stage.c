/* What is added to a wanted voltage that the valve can give [V]; its states go on. */
static real_t added(real_t applied, real_t share, const edges_t *edges, const known_t *own, uint32_t valve,
                    ehamj_law_remembered_t *kept)
{
    const moves_t *step = &MOVES[valve];
    const real_t spool = kept->spool;
    const real_t rate = kept->spool_rate;
    const real_t lag = kept->lagged;
    const real_t slope = kept->lagged_rate;
    const real_t target = own->valve_gain * applied;
    const real_t wanted = spool + (step->ahead * rate);
    const real_t level = kept->level + (step->renewed * ((wanted * wanted) - kept->level));
    const real_t place = place_of(wanted, kept->place, level, own);
    const real_t opening = opening_for(wanted, place, edges, own, CURVE[valve]);
    const real_t lean = leaning(kept->opening, opening, kept->lean, own);
    const real_t more = share * (((opening + (own->play * lean)) - own->offset) - wanted);
    kept->spool = (step->spool_from_spool * spool) + (step->spool_from_rate * rate) + (step->spool_from_target * target);
    kept->spool_rate = (step->rate_from_spool * spool) + (step->rate_from_rate * rate) + (step->rate_from_target * target);
    kept->opening = opening;
    kept->lean = lean;
    kept->lagged = (step->lag_from_lag * lag) + (step->lag_from_slope * slope) + (step->lag_from_more * more);
    kept->lagged_rate = (step->slope_from_lag * lag) + (step->slope_from_slope * slope) + (step->slope_from_more * more);
    kept->place = place;
    kept->level = level;
    return ((step->led_more * more) + (step->led_lag * lag) + (step->led_slope * slope)) / own->valve_gain;
}

/*
 * What fade and the valves' ranges take from what the laws want of each valve, applied - wanted [V]; and, where the
 * stage takes a sample, what is added so that a real valve gives the wanted flow.
 */
static void linearised(ehamj_law_t *law, real_t share, bool samples)
{
    real_t volts[VALVES];
    uint32_t i;
    for (i = 0U; i < (uint32_t)VALVES; i++) {
{% if learns %}
        const known_t *own = &law->known[i];
        const ehamj_law_learnt_t used = law->learnt[i];
{% else %}
        const known_t *own = &KNOWN[i];
{% endif %}
        real_t one = R(0.0);
        real_t two = R(0.0);
        real_t fed = own->supply;
        edges_t edges;
        const real_t total = law->total[i];
        real_t wanted = total;
        real_t applied;
        const real_t far = most(own->reach - own->play, R(0.0));
{% if pressures %}
        if ((own->least < own->most) && (PRESSURE[i][0] >= 0) && (PRESSURE[i][1] >= 0)) {
            one = law->readings[PRESSURE[i][0]];
            two = law->readings[PRESSURE[i][1]];
{% if supply >= 0 %}
            if (own->supply_measured > R(0.0)) {
                fed = law->readings[{{ supply }}];
            }
{% endif %}
        }
{% endif %}
        edges = edges_of(one, two, fed, own);
{% if learns %}
        wanted = corrected(total, law->gathered[i].slow, &LEARNER[i], &used);
{% endif %}
        applied = share * wanted;
        applied = most(applied, asked_at(-far, &edges, own, CURVE[i]));
        applied = least(applied, asked_at(far, &edges, own, CURVE[i]));
{% if learns %}
        law->lost[i] = used.flow_gain * (applied - wanted);
{% else %}
        law->lost[i] = applied - wanted;
{% endif %}
        volts[i] = R(0.0);
        if (samples) {
{% if learns %}
            const real_t spool = law->stage[i].spool;
{% endif %}
            const real_t more = added(applied, share, &edges, own, i, &law->stage[i]);
            volts[i] = more + (share * (wanted - total));
{% if learns %}
            learn(law, i, spool, ABS(more + (share * wanted)) > least(LIMIT, RANGE[i]), &edges);
{% endif %}
        }
    }
    if (samples) {
        queue(law, (uint32_t)ROWS - 1U, volts);
    }
}
