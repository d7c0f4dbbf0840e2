#pragma once
// Objects of HDF5 files that others may have written. HDF5 follows links into other files, reads values of a dataset
// from files that it names, and composes datasets of others: a checkpoint or table could so have the program open what
// it likes. Behind these calls all bytes are of the one file that a user has named.

#include <string>

#include "io/h5.hpp"

namespace moraine {

/// Throws H5Failure(`what`), or one that says that it lies in another file.
H5Id open_group(hid_t at, const std::string& path, const std::string& what);
H5Id open_dataset(hid_t at, const std::string& path, const std::string& what);

/// Throws InputError if the file is HDF5 (netCDF-4 is) and anything of it lies in another file. For libraries that open
/// it by themselves.
void check_hdf5_links(const std::string& path);

}  // namespace moraine
