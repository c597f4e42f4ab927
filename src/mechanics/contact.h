/* Contact between pieces that were never bonded or no longer are (docs/theory.md, section 13).
   Points i and j that hold nothing of each other repel when they come closer than d:

     energy 1/2 k (d - l)^2 for l = |y_j - y_i| < d, else 0
     d = min(range (dx_i + dx_j)/2, |X_j - X_i|)
     k = penalty min(M_i V_i/dx_i^2, M_j V_j/dx_j^2), M the modulus of uniaxial strain: that of the
         bonds between neighbouring layers of a body whose micromodulus makes M

   Since d never exceeds their distance at the start, a pair that breaks does so apart: nothing
   jumps when contact takes over, and faces of a crack close where they were. Forces are central and
   opposite to the last bit. Explicit integrators only.

   Who may touch: points at surfaces, and those with lost bonds. Pairs are found in cells over them
   and kept until something has moved by half a skin. Forces have the same bits for any number of
   threads and whenever pairs were looked for: a point's partners add up in the order of points. */
#ifndef SDR_MECHANICS_CONTACT_H
#define SDR_MECHANICS_CONTACT_H

#include "mechanics/model.h"
#include "scene/scene.h"

typedef struct sdr_contact sdr_contact;

/* Contact as the scene asks for it; *out is NULL if it does not. The model notes lost pairs for it
   from now on (model->lost). Borrows the model. Owner: the caller, who destroys it before the
   model. */
sdr_status sdr_contact_create(const sdr_scene *scene, sdr_model *model, sdr_contact **out);
void sdr_contact_destroy(sdr_contact **contact); /* NULL-safe */

/* Add the forces at u, N. The model's force_commit at the same u has come before. Fails if a list
   cannot grow. */
sdr_status sdr_contact_force(sdr_contact *contact, double *const u[3], double *const f[3]);

/* Energy at the displacements of the latest force or restart, J. */
double sdr_contact_energy(const sdr_contact *contact);

/* Begin anew at u: what follows depends on u and on the bonds alone. */
sdr_status sdr_contact_restart(sdr_contact *contact, double *const u[3]);

/* A bound on the stiffness for the stable step: out += D v with what a surface's points may get
   from other pieces, as a diagonal. N/m times m. */
void sdr_contact_bound_times(const sdr_contact *contact, double *const v[3], double *const out[3]);
/* The largest square of a frequency (1/s^2) that points without bonds may get, hemmed in by others.
 */
double sdr_contact_loose_rate(const sdr_contact *contact, const double *mass);

/* How it stands: points that may touch others, pairs kept, pairs that touch now, and the least l/d
   ever (1: none touched). Near 0 pieces go through each other. */
typedef struct {
  int64_t exposed, candidates, touching;
  double closest;
  int64_t searches; /* since the start or the latest restart */
} sdr_contact_state;
void sdr_contact_look(const sdr_contact *contact, sdr_contact_state *out);

#endif
