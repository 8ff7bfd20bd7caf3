/*
 * What a loop about a spool adds [V] beside what others hold, within the converter's limit; its states go on: the
 * spool is to follow what the known valve makes of the volts.
 */
static real_t fed_back(real_t share, real_t volts, real_t position, uint32_t valve, ehamj_law_follows_t *state)
{
    const spool_t *own = &SPOOL[valve];
    const paces_t *step = &PACES[valve];
    const real_t limit = least(LIMIT, RANGE[valve]);
    const real_t away = (own->valve_gain * least(most(volts, -limit), limit)) - state->spool;
    const real_t far = own->drive_limit / (own->valve_frequency * own->valve_frequency);
    const real_t target = state->spool + least(most(away, -far), far);
    const real_t off = share * ((state->spool - (own->lag * state->spool_rate)) - position);
    const real_t rolled = (step->kept * state->rolled) + ((R(1.0) - step->kept) * off);
    const real_t error = (step->kept * state->error) + ((R(1.0) - step->kept) * rolled);
    const real_t spool = state->spool;
    const real_t rate = state->spool_rate;
    real_t total = state->sum + ((step->now * error) + (step->last * state->error) + (step->before * state->last));
    total = least(most(total, most(-own->limit, least(-limit - volts, R(0.0)))),
                  least(own->limit, most(limit - volts, R(0.0))));
    state->spool = (step->spool_from_spool * spool) + (step->spool_from_rate * rate) + (step->spool_from_target * target);
    state->spool_rate = (step->rate_from_spool * spool) + (step->rate_from_rate * rate) + (step->rate_from_target * target);
    state->last = state->error;
    state->rolled = rolled;
    state->error = error;
    state->sum = total;
    return total;
}

/* Let the loop about each spool take a sample. */
static void feed_back(ehamj_law_t *law, real_t share)
{
    const uint32_t own = {{ fed_row }}U;
    real_t volts[VALVES];
    uint32_t i;
    uint32_t k;
    for (i = 0U; i < (uint32_t)VALVES; i++) {
        real_t others = R(0.0);
        for (k = 0U; k < (uint32_t)ROWS; k++) {
            if (k != own) {
                others += law->held[k][i];
            }
        }
        volts[i] = fed_back(share, others, law->readings[POSITION[i]], i, &law->spools[i]);
    }
    queue(law, own, volts);
}
