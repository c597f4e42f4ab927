/* Faster operations for serial vectors of SUNDIALS. */
#ifndef SDR_TIME_SUN_VECTORS_H
#define SDR_TIME_SUN_VECTORS_H

/* For an N_Vector of N_VNew_Serial; its clones inherit them. */
void sdr_sun_quicken(void *vector);

#endif
