#include "output/hdf.h"

#include "base/memory.h"
#include "output/seal.h"

#include <errno.h>
#include <fcntl.h>
#include <hdf5.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

struct sdr_hdf {
  hid_t id;
  char *path;
};

/* Of the latest failed call. HDF5 forgets it with the next call, the closing ones included. */
static _Thread_local char reason[128];

/* HDF5 buries the system's reason in the deepest record of its error stack. */
static herr_t find_reason(unsigned depth, const H5E_error2_t *record, void *context)
{
  static const char mark[] = "error message = '";
  char *text = context;
  (void)depth;
  if (!record->desc) return 0;
  const char *found = strstr(record->desc, mark);
  if (found) {
    found += sizeof mark - 1;
    snprintf(text, sizeof reason, "%.*s", (int)strcspn(found, "'"), found);
    return 1;
  }
  if (!*text) snprintf(text, sizeof reason, "%s", record->desc);
  return 0;
}

static herr_t note_failure(hid_t stack, void *context)
{
  (void)context;
  reason[0] = '\0';
  H5Ewalk2(stack, H5E_WALK_UPWARD, find_reason, reason);
  return 0;
}

static sdr_status fail_write(const char *path)
{
  return sdr_fail(SDR_IO_ERROR, "cannot write %s: %s", path, reason);
}

static sdr_status fail_read(const sdr_hdf *file, const char *name)
{
  return sdr_fail(SDR_BAD_INPUT, "%s: %s cannot be read: %s", file->path, name, reason);
}

/* HDF5 shall not print, and not try again at the end of the process what a full disk refused. */
static void quieten(void)
{
  H5dont_atexit();
  H5Eset_auto2(H5E_DEFAULT, note_failure, NULL);
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

static sdr_status wrap(const char *path, hid_t id, sdr_hdf **out)
{
  sdr_hdf *file = sdr_alloc(1, sizeof *file);
  char *copy = file ? sdr_strdup(path) : NULL;
  if (!copy) {
    sdr_free(file);
    H5Fclose(id);
    return SDR_RUN_FAILED;
  }
  file->id = id;
  file->path = copy;
  *out = file;
  return SDR_OK;
}

static sdr_status create(const char *path, hsize_t before, sdr_hdf **out)
{
  quieten();
  const hid_t access = access_list(), how = H5Pcreate(H5P_FILE_CREATE);
  H5Pset_userblock(how, before);
  const hid_t id = H5Fcreate(path, H5F_ACC_TRUNC, how, access);
  H5Pclose(how);
  H5Pclose(access);
  if (id < 0) return fail_write(path);
  return wrap(path, id, out);
}

sdr_status sdr_hdf_create(const char *path, sdr_hdf **out)
{
  return create(path, 0, out);
}

sdr_status sdr_hdf_create_sealed(const char *path, sdr_hdf **out)
{
  return create(path, SDR_SEAL_BYTES, out);
}

sdr_status sdr_hdf_open(const char *path, int writable, sdr_hdf **out)
{
  quieten();
  const int probe = open(path, (writable ? O_RDWR : O_RDONLY) | O_CLOEXEC);
  if (probe < 0)
    return sdr_fail(SDR_IO_ERROR, "cannot %s %s: %s", writable ? "write" : "read", path,
                    strerror(errno));
  close(probe);
  const hid_t access = access_list();
  const hid_t id = H5Fopen(path, writable ? H5F_ACC_RDWR : H5F_ACC_RDONLY, access);
  H5Pclose(access);
  if (id < 0) return sdr_fail(SDR_BAD_INPUT, "%s is not a whole HDF5 file: %s", path, reason);
  return wrap(path, id, out);
}

sdr_status sdr_hdf_flush(sdr_hdf *file)
{
  return H5Fflush(file->id, H5F_SCOPE_LOCAL) < 0 ? fail_write(file->path) : SDR_OK;
}

/* 0, or the errno of what stands against `bytes` more in the file. */
static int lacks_room(const char *path, size_t bytes)
{
  struct stat status;
  struct rlimit limit;
  const int file = open(path, O_WRONLY | O_CLOEXEC);
  if (file < 0) return errno;
  int failed = fstat(file, &status) == 0 ? 0 : errno;
  if (!failed && getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY &&
      (rlim_t)status.st_size + bytes > limit.rlim_cur)
    failed = EFBIG;
  if (!failed && fallocate(file, FALLOC_FL_KEEP_SIZE, status.st_size, (off_t)bytes) != 0)
    failed = errno;
  close(file);
  return failed == EOPNOTSUPP || failed == ENOSYS ? 0 : failed;
}

sdr_status sdr_hdf_reserve(sdr_hdf *file, size_t bytes)
{
  const int failed = lacks_room(file->path, bytes);
  if (!failed) return SDR_OK;
  return sdr_fail(SDR_IO_ERROR, "cannot write %s: %s", file->path, strerror(failed));
}

static herr_t release(sdr_hdf **file)
{
  const herr_t result = H5Fclose((*file)->id);
  sdr_free((*file)->path);
  sdr_free(*file);
  *file = NULL;
  return result;
}

sdr_status sdr_hdf_close(sdr_hdf **file)
{
  char path[PATH_MAX];
  if (!*file) return SDR_OK;
  snprintf(path, sizeof path, "%s", (*file)->path);
  return release(file) < 0 ? fail_write(path) : SDR_OK;
}

void sdr_hdf_discard(sdr_hdf **file)
{
  if (*file) release(file);
}

static hid_t type_of(sdr_hdf_type type)
{
  switch (type) {
  case SDR_HDF_FLOAT:
    return H5T_NATIVE_FLOAT;
  case SDR_HDF_DOUBLE:
    return H5T_NATIVE_DOUBLE;
  case SDR_HDF_INT32:
    return H5T_NATIVE_INT32;
  case SDR_HDF_INT64:
    return H5T_NATIVE_INT64;
  case SDR_HDF_BYTES:
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

static sdr_status write_dataset(sdr_hdf *file, const char *name, hid_t type, hid_t space,
                                const void *data, const char *unit)
{
  const hid_t dataset = make_dataset(file->id, name, type, space);
  herr_t result = dataset < 0 ? -1 : H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data);
  if (result >= 0 && unit) result = write_attribute(dataset, "unit", unit);
  const sdr_status status = result < 0 ? fail_write(file->path) : SDR_OK;
  if (dataset >= 0 && H5Dclose(dataset) < 0 && status == SDR_OK) return fail_write(file->path);
  return status;
}

sdr_status sdr_hdf_write(sdr_hdf *file, const char *name, sdr_hdf_shape shape, const void *data,
                         const char *unit)
{
  const hsize_t sizes[2] = {shape.rows, shape.columns};
  const hid_t space =
      shape.rank == 0 ? H5Screate(H5S_SCALAR) : H5Screate_simple(shape.rank, sizes, NULL);
  if (space < 0) return fail_write(file->path);
  const sdr_status status = write_dataset(file, name, type_of(shape.type), space, data, unit);
  H5Sclose(space);
  return status;
}

sdr_status sdr_hdf_write_text(sdr_hdf *file, const char *name, const char *text)
{
  const hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate(H5S_SCALAR);
  H5Tset_size(type, strlen(text) + 1);
  const sdr_status status = write_dataset(file, name, type, space, text, NULL);
  H5Sclose(space);
  H5Tclose(type);
  return status;
}

int sdr_hdf_has(sdr_hdf *file, const char *name)
{
  char part[256];
  snprintf(part, sizeof part, "%s", name);
  for (char *slash = strchr(part + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
    *slash = '\0';
    if (H5Lexists(file->id, part, H5P_DEFAULT) <= 0) return 0;
    *slash = '/';
  }
  return H5Lexists(file->id, part, H5P_DEFAULT) > 0;
}

static sdr_hdf_type type_in_file(hid_t dataset)
{
  const hid_t type = H5Dget_type(dataset);
  const size_t bytes = H5Tget_size(type);
  const int real = H5Tget_class(type) == H5T_FLOAT;
  H5Tclose(type);
  if (real) return bytes == sizeof(float) ? SDR_HDF_FLOAT : SDR_HDF_DOUBLE;
  return bytes == 4 ? SDR_HDF_INT32 : bytes == 8 ? SDR_HDF_INT64 : SDR_HDF_BYTES;
}

/* 0 if the dataset has another rank than ours. */
static int shape_of(hid_t dataset, sdr_hdf_shape *shape)
{
  hsize_t sizes[2] = {1, 1};
  const hid_t space = H5Dget_space(dataset);
  const int rank = H5Sget_simple_extent_ndims(space);
  const int known = rank >= 0 && rank <= 2;
  if (known) H5Sget_simple_extent_dims(space, sizes, NULL);
  H5Sclose(space);
  *shape = (sdr_hdf_shape){type_in_file(dataset), rank, (size_t)sizes[0], (size_t)sizes[1]};
  return known;
}

sdr_status sdr_hdf_shape_of(sdr_hdf *file, const char *name, sdr_hdf_shape *shape)
{
  sdr_hdf_shape found;
  const hid_t dataset = H5Dopen2(file->id, name, H5P_DEFAULT);
  if (dataset < 0) return fail_read(file, name);
  const int known = shape_of(dataset, &found);
  H5Dclose(dataset);
  if (!known)
    return sdr_fail(SDR_BAD_INPUT, "%s: %s has more than two dimensions", file->path, name);
  *shape = found;
  return SDR_OK;
}

sdr_status sdr_hdf_read(sdr_hdf *file, const char *name, sdr_hdf_shape shape, void *data)
{
  sdr_hdf_shape found;
  sdr_status status = SDR_OK;
  const hid_t dataset = H5Dopen2(file->id, name, H5P_DEFAULT);
  if (dataset < 0) return fail_read(file, name);
  if (!shape_of(dataset, &found) || found.rows * found.columns != shape.rows * shape.columns)
    status = sdr_fail(SDR_BAD_INPUT, "%s: %s holds %zu values, not %zu", file->path, name,
                      found.rows * found.columns, shape.rows * shape.columns);
  else if (H5Dread(dataset, type_of(shape.type), H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0)
    status = fail_read(file, name);
  H5Dclose(dataset);
  return status;
}

sdr_status sdr_hdf_read_text(sdr_hdf *file, const char *name, char *text, size_t size)
{
  const hid_t dataset = H5Dopen2(file->id, name, H5P_DEFAULT);
  if (dataset < 0) return fail_read(file, name);
  sdr_status status = SDR_OK;
  const hid_t stored = H5Dget_type(dataset), type = H5Tcopy(H5T_C_S1);
  H5Tset_size(type, size);
  if (H5Tget_class(stored) != H5T_STRING || H5Tis_variable_str(stored) > 0 ||
      H5Dread(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text) < 0)
    status = fail_read(file, name);
  H5Tclose(type);
  H5Tclose(stored);
  H5Dclose(dataset);
  return status;
}

int sdr_hdf_count(sdr_hdf *file, const char *group)
{
  H5G_info_t info;
  if (H5Gget_info_by_name(file->id, group, &info, H5P_DEFAULT) < 0) return 0;
  return (int)info.nlinks;
}

sdr_status sdr_hdf_copy(sdr_hdf *from, sdr_hdf *to, const char *name)
{
  if (H5Ocopy(from->id, name, to->id, name, H5P_DEFAULT, H5P_DEFAULT) < 0)
    return fail_write(to->path);
  return SDR_OK;
}
