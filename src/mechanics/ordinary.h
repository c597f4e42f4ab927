/* Shared by the files that make up the ordinary state-based model; see ordinary_body.h for what it
   computes, state_based.h for how one is made. */
#ifndef SDR_MECHANICS_ORDINARY_H
#define SDR_MECHANICS_ORDINARY_H

#include "mechanics/ordinary_body.h"

/* S and lost sums of all points at u, over the bonds that `use` counts; `squares`: Q too (then use
   is SDR_FLAGS_KEEP). */
void sdr_ordinary_sum(sdr_ordinary *o, double *const u[3], sdr_flags_use use, int squares);

/* P, Q and P^2/Q of the half i -> j of a pair. */
static inline double sdr_ordinary_p(const sdr_ordinary *o, const sdr_pair *pair, double weight)
{
  return o->form == SDR_FORM_MADENCI_OTERKUS ? weight : weight * pair->length * pair->length;
}
static inline double sdr_ordinary_q(const sdr_ordinary *o, const sdr_pair *pair, double weight)
{
  return weight * pair->length * (o->form == SDR_FORM_MADENCI_OTERKUS ? 1.0 : pair->length);
}
static inline double sdr_ordinary_r(const sdr_ordinary *o, const sdr_pair *pair, double weight)
{
  return o->form == SDR_FORM_MADENCI_OTERKUS ? weight / pair->length
                                             : weight * pair->length * pair->length;
}

/* s0^2 of every point, such that a plane cut takes Gc (J/m^2, a material index), as nearly as can
   be for cuts in any direction. */
sdr_status sdr_ordinary_set_threshold(sdr_ordinary *o, const double *toughness);

/* Parts of the model in their own files. */
void sdr_ordinary_book(sdr_state_body *body, double *const u[3], double *const v[3], double dt);
void sdr_ordinary_remake_fresh(sdr_state_body *body);
sdr_status sdr_ordinary_field(sdr_model *model, double *const u[3], sdr_model_field which,
                              double *out);
void sdr_ordinary_reference_times(sdr_model *model, double *const v[3], double *const out[3]);
sdr_status sdr_ordinary_tangent_times(sdr_model *model, double *const u[3], double *const v[3],
                                      double *const out[3]);
sdr_status sdr_ordinary_tangent_diagonal(sdr_model *model, double *const u[3], double *out);
sdr_status sdr_ordinary_visit_hessian(sdr_model *model, double *const u[3],
                                      sdr_hessian_visitor visitor, void *context);
sdr_status sdr_ordinary_visit_secant(sdr_model *model, double *const u[3],
                                     sdr_hessian_visitor visitor, void *context);

#endif
