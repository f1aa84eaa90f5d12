//! Why a stage gives no result. Each variant names the requirement that asks for it.

use core::fmt;

/// Why a scan line gives no layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineRefusal {
    /// LINE-2
    Width,
    /// THRESH-4
    LowContrast,
    /// REGION-5
    TooManyRegions,
    /// DECODE-2
    TooManyLayers,
}

/// Why an ROI gives no layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HypothesisRefusal {
    /// HYPO-6
    TooFewBars,
    /// HYPO-7
    TooManyBars,
    /// HYPO-8
    CutOff,
    /// HYPO-9
    QuietZone,
    /// HYPO-11
    TooNarrow,
    /// HOMOG-3
    Implausible,
    /// SAMPLE-5
    Guard,
    /// SAMPLE-6, SAMPLE-8
    Transition,
    /// SAMPLE-10
    Residual,
}

/// Why a pair of layers gives no detection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PairRefusal {
    /// CODE-7
    EqualHalves,
    /// CODE-8
    Crc,
}

impl fmt::Display for LineRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Width => "the scan line is not as wide as the camera",
            Self::LowContrast => "the scan line has less than 24 grey levels of contrast",
            Self::TooManyRegions => "the scan line has more than 255 regions",
            Self::TooManyLayers => "the scan line has more than 8 decoded regions of interest",
        })
    }
}

impl fmt::Display for HypothesisRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::TooFewBars => "it has fewer bars than the guards",
            Self::TooManyBars => "it has more bars than the format",
            Self::CutOff => "it is cut off at an end of the line",
            Self::QuietZone => "it has no quiet zone",
            Self::TooNarrow => "it has less than 1.25 pixels per stripe",
            Self::Implausible => "no view of a barcode has this homography",
            Self::Guard => "a guard stripe does not fall in its region",
            Self::Transition => "its transitions are not the changes between its stripes",
            Self::Residual => "its transitions do not lie where the format has edges",
        })
    }
}

impl fmt::Display for PairRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::EqualHalves => "both layers are the same",
            Self::Crc => "the check byte is wrong",
        })
    }
}
