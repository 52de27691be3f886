// Where ITK is not to be had (Debian 12 has it for amd64 alone): the other formats are read all the same.
#include "tools/hapticctl-import/itk/scan_file.h"

namespace hapticctl_import {
namespace {

[[noreturn]] void refuse() {
  throw ImportError("", "no format that this program was built to read: DICOM, NIfTI, NRRD and MetaImage need ITK",
                    "import it on another machine with --output, and load what comes out with hapticctl load");
}

}  // namespace

Image readScan(const std::string&) { refuse(); }
bool isDicom(const std::string&) { return false; }  // A folder is taken for one all the same, and refused.
std::vector<DicomSeries> dicomSeriesIn(const std::string&) { refuse(); }
Image readSeries(const DicomSeries&) { refuse(); }

}  // namespace hapticctl_import
