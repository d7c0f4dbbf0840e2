#pragma once
// Classic netCDF (CDF-1, -2 and -5) has no length in its header, and what a short file lacks is read as zeros. The
// header says where the values of each variable begin and how many they are: the file must reach their end.
// Format: https://docs.unidata.ucar.edu/netcdf-c/current/file_format_specifications.html. Files of netCDF-4 are HDF5,
// which checks its own end.

#include <string>

namespace moraine {

/// Throws InputError where the file is such a one and too short, or its header cannot be. Other files are good.
void check_netcdf_size(const std::string& path);

}  // namespace moraine
