//! What can be chosen about the writing of a recording.

/// An enum whose variants can be counted through.
macro_rules! choices {
    ($($(#[$doc:meta])* $name:ident { $($level:ident),+ $(,)? })+) => {$(
        $(#[$doc])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum $name { $($level),+ }

        impl $name {
            pub const ALL: &'static [$name] = &[$($name::$level),+];
        }
    )+};
}

choices! {
    /// What was recorded, and in how many files.
    Scene {
        // Six faces and six free poses, one continuous recording.
        Poses,
        // Six faces and three turns by −360°, one continuous recording.
        Turns,
        // Six files, named after the axis that points up.
        SixFiles,
        // Three files, named after an axis: up, three blank rows, down.
        AxisFiles,
        // The poses in two continuous recordings.
        TwoRecordings,
        // Rest, 0.7 m along y, rest.
        Line,
    }

    Rate { Hz25, Hz50, Hz100, Hz200, Hz1000 }

    /// Full scale of the accelerometer, g; it matters for counts only.
    Range { G2, G4, G8, G16 }

    /// Which sensors are there.
    Sensors { Both, AccelerometerOnly, GyroscopeInOtherFile }

    /// Units of accelerometer and gyroscope; mislabelled: m/s² and rad/s under a header that says g
    /// and °/s.
    Values {
        Mps2Rad, Mps2Deg, GRad, GDeg, MilliGDeg, Counts, Mislabelled,
    }

    Decimals { Two, Three, Four, Six }

    Delimiter {
        Comma, CommaSpace, Semicolon, Tab, Bar, Padded, SemicolonDecimalComma, TabDecimalComma,
    }

    LineEnd { Lf, CrLf, CrLfTwice, CrCrLf, Cr }

    /// A blank line after every so many rows.
    Blank { Never, Every2, Every10, Every100 }

    /// What ends a line; rows only: the header has no delimiter at its end.
    Trailing { Nothing, Delimiter, RowsOnly }

    Encoding { Utf8, Utf8Mark, Utf16Le, Utf16Be, Utf16LeBare, Latin1, Gzip }

    /// Letters: none, but the letter of each sensor before its values: `A: x y z G: x y z`.
    Header {
        Absent, Letters, Plain, Quoted, Commented, Repeated, UnitsRow, CalAndUnitsRow, TwoRows, Metadata,
        SepLine,
    }

    /// Whose names the columns have; bare: x, y, z, and the sensor in the name of the file.
    Names {
        Sketch, Short, Camel, Snake, Phyphox, Xio, Euroc, Ros, Px4, ArduPilot, Shimmer, Phone,
        Bare,
    }

    /// Linear acceleration lacks gravity; it stands before the accelerometer or behind it.
    Order {
        AccelFirst, GyroFirst, ZyxAxes, MagnetometerFirst, LinearFirst, TemperatureBetween,
        CounterFirst, TextColumns,
    }

    /// Days as spreadsheets count them; parts: hours, minutes, seconds and milliseconds.
    Clock {
        Milliseconds, Seconds, Microseconds, Minutes, Days, EpochSeconds, EpochMilliseconds,
        EpochNanoseconds, DateTime, DateAndTime, TimeOfDay, Parts, Differences, Absent,
    }

    /// What the clock's column is called where the logger has no name of its own for it.
    ClockName { Plain, WithUnit, Logger, Unheard }
}

macro_rules! writing {
    ($($field:ident: $kind:ident),+ $(,)?) => {
        /// One way of writing a recording.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub struct Writing { $(pub $field: $kind),+ }

        impl Writing {
            /// A writing that is drawn: `draw(n)` is less than n.
            pub fn random(mut draw: impl FnMut(usize) -> usize) -> Self {
                let drawn = Writing { $($field: $kind::ALL[draw($kind::ALL.len())]),+ };
                drawn.possible()
            }

            /// Every two of its choices: number of each list, and of the choice in it.
            pub fn pairs(&self) -> Vec<[(usize, usize); 2]> {
                let choices = [$(self.$field as usize),+];
                let choices: Vec<(usize, usize)> = choices.into_iter().enumerate().collect();
                let pair = |at: usize| choices[..at].iter().map(|c| [*c, choices[at]]).collect();
                (0..choices.len()).flat_map::<Vec<_>, _>(pair).collect()
            }
        }
    };
}

writing! {
    scene: Scene,
    rate: Rate,
    range: Range,
    sensors: Sensors,
    values: Values,
    decimals: Decimals,
    delimiter: Delimiter,
    line_end: LineEnd,
    blank: Blank,
    trailing: Trailing,
    encoding: Encoding,
    header: Header,
    names: Names,
    order: Order,
    clock: Clock,
    clock_name: ClockName,
}

impl Rate {
    pub fn hz(self) -> f64 {
        [25.0, 50.0, 100.0, 200.0, 1000.0][self as usize]
    }
}

impl Range {
    pub fn lsb_per_g(self) -> f64 {
        [16384.0, 8192.0, 4096.0, 2048.0][self as usize]
    }

    /// That of the gyroscope beside it.
    pub fn lsb_per_deg_s(self) -> f64 {
        [131.0, 65.5, 32.8, 16.4][self as usize]
    }
}

impl Decimals {
    pub fn digits(self) -> usize {
        [2, 3, 4, 6][self as usize]
    }
}

impl Blank {
    pub fn every(self) -> Option<usize> {
        [None, Some(2), Some(10), Some(100)][self as usize]
    }
}

impl Writing {
    /// The form in which nothing is lost and nothing has to be found out.
    pub fn plain(scene: Scene, rate: Rate) -> Self {
        Writing {
            scene,
            rate,
            range: Range::G16,
            sensors: Sensors::Both,
            values: Values::Mps2Rad,
            decimals: Decimals::Six,
            delimiter: Delimiter::Comma,
            line_end: LineEnd::Lf,
            blank: Blank::Never,
            trailing: Trailing::Nothing,
            encoding: Encoding::Utf8,
            header: Header::Plain,
            names: Names::Sketch,
            order: Order::AccelFirst,
            clock: Clock::Seconds,
            clock_name: ClockName::WithUnit,
        }
    }

    /// The nearest writing that somebody can have: loggers have units of their own, a file
    /// without a header has no names ….
    pub fn possible(mut self) -> Self {
        use Header as H;
        use Names as N;
        if self.header == H::Letters {
            // Words and blanks part the values.
            self.delimiter = Delimiter::Padded;
            if self.order != Order::MagnetometerFirst {
                self.order = Order::AccelFirst;
            }
        }
        let headed = !matches!(self.header, H::Absent | H::Letters);
        // One file of two sensors is joined to one recording.
        if self.sensors == Sensors::GyroscopeInOtherFile
            && !matches!(self.scene, Scene::Poses | Scene::Turns | Scene::Line)
        {
            self.sensors = Sensors::Both;
        }
        if self.sensors == Sensors::GyroscopeInOtherFile && self.clock == Clock::Absent {
            self.clock = Clock::Milliseconds;
        }
        if self.names == N::Bare && self.sensors == Sensors::Both {
            self.sensors = Sensors::AccelerometerOnly;
        }
        if headed && self.values != Values::Counts && self.values != Values::Mislabelled {
            self.values = match self.names {
                N::Phyphox | N::Euroc | N::Ros | N::Px4 | N::ArduPilot => Values::Mps2Rad,
                N::Xio | N::Phone => Values::GDeg,
                N::Shimmer => Values::Mps2Deg,
                _ => self.values,
            };
        }
        if self.values == Values::Mislabelled {
            // It is the sketch of the report that does so.
            self.names = N::Sketch;
            if !headed {
                self.values = Values::Mps2Rad;
            }
        }
        if self.values == Values::Counts {
            self.decimals = Decimals::Six;
            if !matches!(self.names, N::Short | N::Camel | N::Bare) {
                self.names = N::Short;
            }
        }
        if self.header == H::TwoRows {
            self.names = N::Short;
            if self.order == Order::TextColumns || self.order == Order::CounterFirst {
                self.order = Order::AccelFirst;
            }
            // Its name says that it is a time, not a difference or a part.
            if matches!(
                self.clock,
                Clock::Differences | Clock::Parts | Clock::DateAndTime
            ) {
                self.clock = Clock::Seconds;
            }
        }
        if !headed {
            self.names = N::Short;
            self.clock_name = ClockName::Plain;
            // Nobody can know that a column holds differences or parts, and what a column of
            // words or of another sensor is.
            if matches!(self.clock, Clock::Differences | Clock::Parts) {
                self.clock = Clock::Milliseconds;
            }
            let is_lettered = self.header == H::Letters;
            let is_unknown = matches!(self.order, Order::MagnetometerFirst | Order::LinearFirst);
            if self.order == Order::TextColumns || is_unknown && !is_lettered {
                self.order = Order::AccelFirst;
            }
        }
        // What parts the two directions of one file has to be rarer than what is blank
        // all the time.
        if matches!(self.line_end, LineEnd::CrLfTwice | LineEnd::CrCrLf) {
            self.blank = Blank::Never;
        }
        if self.order == Order::TextColumns && self.delimiter == Delimiter::Padded {
            self.delimiter = Delimiter::Tab;
        }
        if self.delimiter == Delimiter::Padded {
            self.trailing = Trailing::Nothing;
            self.header = match self.header {
                H::Absent | H::Letters | H::Plain | H::Commented | H::Repeated | H::UnitsRow => {
                    self.header
                }
                _ => H::Plain,
            };
            // A name with spaces in it is cut by them.
            if headed {
                self.names = match self.names {
                    N::Camel | N::Bare => self.names,
                    _ => N::Short,
                };
            }
            if self.values == Values::Mislabelled {
                self.values = Values::Mps2Rad;
            }
            if self.clock == Clock::DateTime {
                self.clock = Clock::TimeOfDay;
            }
        }
        // Milliseconds of a sensor that is read a thousand times a second count its rows.
        if self.rate == Rate::Hz1000
            && matches!(self.clock, Clock::Milliseconds | Clock::EpochMilliseconds)
            && self.clock_name == ClockName::Unheard
        {
            self.clock_name = ClockName::Logger;
        }
        // Three axes without names are x, y, z.
        if !headed && self.sensors == Sensors::GyroscopeInOtherFile && self.order == Order::ZyxAxes
        {
            self.order = Order::AccelFirst;
        }
        // Without a clock nothing tells a blank line or a header that is written again
        // from a placement that begins: docs/recording.md says so.
        if self.clock == Clock::Absent {
            if self.header == H::Repeated {
                self.header = H::Plain;
            }
            if self.blank == Blank::Every100 {
                self.blank = Blank::Never;
            }
        }
        if self.sensors == Sensors::AccelerometerOnly && self.order == Order::GyroFirst {
            self.order = Order::AccelFirst;
        }
        self
    }

    /// What the file alone does not say, so that an option may have to.
    pub fn has_gyro(&self) -> bool {
        self.sensors != Sensors::AccelerometerOnly
    }
}
