#include "output/store.h"

#include "base/memory.h"

#include <errno.h>
#include <fcntl.h>
#include <hdf5.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

struct sdr_store {
  hid_t file;
  char *path;
};

/* HDF5 buries the system's reason in the deepest record of its error stack. */
static herr_t find_reason(unsigned depth, const H5E_error2_t *record, void *context)
{
  static const char mark[] = "error message = '";
  char *reason = context;
  (void)depth;
  if (!record->desc) return 0;
  const char *found = strstr(record->desc, mark);
  if (found) {
    found += sizeof mark - 1;
    snprintf(reason, 128, "%.*s", (int)strcspn(found, "'"), found);
    return 1;
  }
  if (!*reason) snprintf(reason, 128, "%s", record->desc);
  return 0;
}

static const char *reason_of_failure(char reason[128])
{
  *reason = '\0';
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, find_reason, reason);
  return *reason ? reason : "HDF5 gives no reason";
}

static sdr_status fail_write(const char *path)
{
  char reason[128];
  return sdr_fail(SDR_IO_ERROR, "cannot write %s: %s", path, reason_of_failure(reason));
}

static sdr_status fail_read(const sdr_store *store, const char *name)
{
  char reason[128];
  return sdr_fail(SDR_BAD_INPUT, "%s: %s cannot be read: %s", store->path, name,
                  reason_of_failure(reason));
}

/* HDF5 shall neither print nor, after a full disk, try again when the process exits. */
static void quieten(void)
{
  H5dont_atexit();
  H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
}

/* No locks of HDF5's own: the run's directory has one, and readers may look while it is written.
   Closing a file closes what is open in it. */
static hid_t access_list(void)
{
  const hid_t list = H5Pcreate(H5P_FILE_ACCESS);
  H5Pset_file_locking(list, 0, 1);
  H5Pset_fclose_degree(list, H5F_CLOSE_STRONG);
  return list;
}

static sdr_status wrap(const char *path, hid_t file, sdr_store **out)
{
  sdr_store *store = sdr_alloc(1, sizeof *store);
  char *copy = store ? sdr_strdup(path) : NULL;
  if (!copy) {
    sdr_free(store);
    H5Fclose(file);
    return SDR_RUN_FAILED;
  }
  store->file = file;
  store->path = copy;
  *out = store;
  return SDR_OK;
}

sdr_status sdr_store_create(const char *path, sdr_store **out)
{
  quieten();
  const hid_t access = access_list();
  const hid_t file = H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, access);
  H5Pclose(access);
  if (file < 0) return fail_write(path);
  return wrap(path, file, out);
}

sdr_status sdr_store_open(const char *path, int writable, sdr_store **out)
{
  quieten();
  const int probe = open(path, (writable ? O_RDWR : O_RDONLY) | O_CLOEXEC);
  if (probe < 0)
    return sdr_fail(SDR_IO_ERROR, "cannot %s %s: %s", writable ? "write" : "read", path,
                    strerror(errno));
  close(probe);
  const hid_t access = access_list();
  const hid_t file = H5Fopen(path, writable ? H5F_ACC_RDWR : H5F_ACC_RDONLY, access);
  H5Pclose(access);
  if (file < 0) {
    char reason[128];
    return sdr_fail(SDR_BAD_INPUT, "%s is not a whole HDF5 file: %s", path,
                    reason_of_failure(reason));
  }
  return wrap(path, file, out);
}

sdr_status sdr_store_flush(sdr_store *store)
{
  return H5Fflush(store->file, H5F_SCOPE_LOCAL) < 0 ? fail_write(store->path) : SDR_OK;
}

sdr_status sdr_store_close(sdr_store **store)
{
  sdr_store *s = *store;
  if (!s) return SDR_OK;
  const sdr_status status = H5Fclose(s->file) < 0 ? fail_write(s->path) : SDR_OK;
  sdr_free(s->path);
  sdr_free(s);
  *store = NULL;
  return status;
}

static hid_t type_of(sdr_store_type type)
{
  switch (type) {
  case SDR_STORE_FLOAT:
    return H5T_NATIVE_FLOAT;
  case SDR_STORE_DOUBLE:
    return H5T_NATIVE_DOUBLE;
  case SDR_STORE_INT32:
    return H5T_NATIVE_INT32;
  case SDR_STORE_INT64:
    return H5T_NATIVE_INT64;
  case SDR_STORE_BYTES:
    return H5T_NATIVE_UINT8;
  }
  return H5I_INVALID_HID;
}

static herr_t write_attribute(hid_t dataset, const char *name, const char *text)
{
  const hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate(H5S_SCALAR);
  H5Tset_size(type, strlen(text) + 1);
  const hid_t attribute = H5Acreate2(dataset, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
  herr_t result = attribute < 0 ? -1 : H5Awrite(attribute, type, text);
  if (attribute >= 0 && H5Aclose(attribute) < 0) result = -1;
  H5Sclose(space);
  H5Tclose(type);
  return result;
}

/* A dataset without times of its own, so that equal runs give equal files. */
static hid_t make_dataset(hid_t file, const char *name, hid_t type, hid_t space)
{
  const hid_t links = H5Pcreate(H5P_LINK_CREATE), how = H5Pcreate(H5P_DATASET_CREATE);
  H5Pset_create_intermediate_group(links, 1);
  H5Pset_obj_track_times(how, 0);
  const hid_t dataset = H5Dcreate2(file, name, type, space, links, how, H5P_DEFAULT);
  H5Pclose(how);
  H5Pclose(links);
  return dataset;
}

static sdr_status write_dataset(sdr_store *store, const char *name, hid_t type, hid_t space,
                                const void *data, const char *unit)
{
  const hid_t dataset = make_dataset(store->file, name, type, space);
  herr_t result = dataset < 0 ? -1 : H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data);
  if (result >= 0 && unit) result = write_attribute(dataset, "unit", unit);
  const sdr_status status = result < 0 ? fail_write(store->path) : SDR_OK;
  if (dataset >= 0 && H5Dclose(dataset) < 0 && status == SDR_OK) return fail_write(store->path);
  return status;
}

sdr_status sdr_store_write(sdr_store *store, const char *name, sdr_store_shape shape,
                           const void *data, const char *unit)
{
  const hsize_t sizes[2] = {shape.rows, shape.columns};
  const hid_t space =
      shape.rank == 0 ? H5Screate(H5S_SCALAR) : H5Screate_simple(shape.rank, sizes, NULL);
  if (space < 0) return fail_write(store->path);
  const sdr_status status = write_dataset(store, name, type_of(shape.type), space, data, unit);
  H5Sclose(space);
  return status;
}

sdr_status sdr_store_write_text(sdr_store *store, const char *name, const char *text)
{
  const hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate(H5S_SCALAR);
  H5Tset_size(type, strlen(text) + 1);
  const sdr_status status = write_dataset(store, name, type, space, text, NULL);
  H5Sclose(space);
  H5Tclose(type);
  return status;
}

int sdr_store_has(sdr_store *store, const char *name)
{
  char part[256];
  snprintf(part, sizeof part, "%s", name);
  for (char *slash = strchr(part + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
    *slash = '\0';
    if (H5Lexists(store->file, part, H5P_DEFAULT) <= 0) return 0;
    *slash = '/';
  }
  return H5Lexists(store->file, part, H5P_DEFAULT) > 0;
}

static sdr_store_type type_in_file(hid_t dataset)
{
  const hid_t type = H5Dget_type(dataset);
  const size_t bytes = H5Tget_size(type);
  const int real = H5Tget_class(type) == H5T_FLOAT;
  H5Tclose(type);
  if (real) return bytes == sizeof(float) ? SDR_STORE_FLOAT : SDR_STORE_DOUBLE;
  return bytes == 4 ? SDR_STORE_INT32 : bytes == 8 ? SDR_STORE_INT64 : SDR_STORE_BYTES;
}

/* 0 if the dataset has another rank than ours. */
static int shape_of(hid_t dataset, sdr_store_shape *shape)
{
  hsize_t sizes[2] = {1, 1};
  const hid_t space = H5Dget_space(dataset);
  const int rank = H5Sget_simple_extent_ndims(space);
  const int known = rank >= 0 && rank <= 2;
  if (known) H5Sget_simple_extent_dims(space, sizes, NULL);
  H5Sclose(space);
  *shape = (sdr_store_shape){type_in_file(dataset), rank, (size_t)sizes[0], (size_t)sizes[1]};
  return known;
}

sdr_status sdr_store_shape_of(sdr_store *store, const char *name, sdr_store_shape *shape)
{
  sdr_store_shape found;
  const hid_t dataset = H5Dopen2(store->file, name, H5P_DEFAULT);
  if (dataset < 0) return fail_read(store, name);
  const int known = shape_of(dataset, &found);
  H5Dclose(dataset);
  if (!known)
    return sdr_fail(SDR_BAD_INPUT, "%s: %s has more than two dimensions", store->path, name);
  *shape = found;
  return SDR_OK;
}

sdr_status sdr_store_read(sdr_store *store, const char *name, sdr_store_shape shape, void *data)
{
  sdr_store_shape found;
  sdr_status status = SDR_OK;
  const hid_t dataset = H5Dopen2(store->file, name, H5P_DEFAULT);
  if (dataset < 0) return fail_read(store, name);
  if (!shape_of(dataset, &found) || found.rows * found.columns != shape.rows * shape.columns)
    status = sdr_fail(SDR_BAD_INPUT, "%s: %s holds %zu values, not %zu", store->path, name,
                      found.rows * found.columns, shape.rows * shape.columns);
  else if (H5Dread(dataset, type_of(shape.type), H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0)
    status = fail_read(store, name);
  H5Dclose(dataset);
  return status;
}

sdr_status sdr_store_read_text(sdr_store *store, const char *name, char *text, size_t size)
{
  const hid_t dataset = H5Dopen2(store->file, name, H5P_DEFAULT);
  if (dataset < 0) return fail_read(store, name);
  sdr_status status = SDR_OK;
  const hid_t stored = H5Dget_type(dataset), type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, size);
  if (H5Tget_class(stored) != H5T_STRING || H5Tis_variable_str(stored) > 0 ||
      H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text) < 0)
    status = fail_read(store, name);
  H5Tclose(type);
  H5Tclose(stored);
  H5Dclose(dataset);
  return status;
}

int sdr_store_count(sdr_store *store, const char *group)
{
  H5G_info_t info;
  if (H5Gget_info_by_name(store->file, group, &info, H5P_DEFAULT) < 0) return 0;
  return (int)info.nlinks;
}

sdr_status sdr_store_name(sdr_store *store, const char *group, int k, char *name, size_t size)
{
  const ssize_t length = H5Lget_name_by_idx(store->file, group, H5_INDEX_NAME, H5_ITER_INC,
                                            (hsize_t)k, name, size, H5P_DEFAULT);
  return length < 0 ? fail_read(store, group) : SDR_OK;
}

sdr_status sdr_store_remove(sdr_store *store, const char *name)
{
  return H5Ldelete(store->file, name, H5P_DEFAULT) < 0 ? fail_write(store->path) : SDR_OK;
}
