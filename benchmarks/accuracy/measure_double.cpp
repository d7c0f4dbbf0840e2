#include "accuracy/measure.ipp"

namespace moraine {
template Measured measure<double>(const AccuracyCase&, const Configuration&, int);
}
