-- Version 5: everything a laboratory stores, redrawn once for every kind of planar machine on linear axes. It is
-- complete in itself: files 0001 to 0004 are there to read older databases, which `db migrate` copies into this form.
-- Append-only from here on: a change is a new numbered file.
-- Units stand in the column names. Lengths mm, angles rad (the exact bits the program computes with;
-- the views give degrees). Times of day are UTC, ISO 8601. JSON is checked by the program: json_valid()
-- is not allowed in a schema that is not trusted. store/README.md explains table by table.

-- What is measured: one machine under one instrument. Sigmas are of one reading; that of phi is NULL where phi is not
-- measured, both where none is stated.
CREATE TABLE campaign (
  campaign_id INTEGER PRIMARY KEY,
  uuid TEXT NOT NULL UNIQUE CHECK (length(uuid) = 36),
  name TEXT NOT NULL UNIQUE CHECK (length(name) BETWEEN 1 AND 200),
  kind TEXT NOT NULL CHECK (kind IN ('real', 'simulated')),
  origin TEXT NOT NULL CHECK (origin IN ('measured', 'imported')),
  created_utc TEXT NOT NULL CHECK (length(created_utc) BETWEEN 20 AND 30),
  tracker_sigma_xy_mm REAL CHECK (tracker_sigma_xy_mm >= 0 AND tracker_sigma_xy_mm <= 100),
  tracker_sigma_phi_rad REAL CHECK (tracker_sigma_phi_rad >= 0 AND tracker_sigma_phi_rad <= 10),
  CHECK (tracker_sigma_xy_mm IS NOT NULL OR tracker_sigma_phi_rad IS NULL)
) STRICT;

-- The campaign's machine, nominal, and which coordinates of the platform are measured.
CREATE TABLE machine (
  campaign_id INTEGER PRIMARY KEY REFERENCES campaign,
  kind TEXT NOT NULL CHECK (kind IN ('3-PRR', '3-PPR', '3-RPR', 'XY', 'X')),
  home_x_mm REAL NOT NULL CHECK (home_x_mm BETWEEN -1e5 AND 1e5),
  home_y_mm REAL NOT NULL CHECK (home_y_mm BETWEEN -1e5 AND 1e5),
  home_phi_rad REAL NOT NULL CHECK (home_phi_rad BETWEEN -100 AND 100),
  measures_x INTEGER NOT NULL CHECK (measures_x IN (0, 1)),
  measures_y INTEGER NOT NULL CHECK (measures_y IN (0, 1)),
  measures_phi INTEGER NOT NULL CHECK (measures_phi IN (0, 1)),
  CHECK (measures_x + measures_y + measures_phi > 0)
) STRICT;

-- Parameters of each of its chains: those of the chain's kind, by their names, each with its unit (r_mm, alpha_rad).
CREATE TABLE machine_chain (
  campaign_id INTEGER NOT NULL REFERENCES machine,
  chain INTEGER NOT NULL CHECK (chain BETWEEN 1 AND 3),
  parameter TEXT NOT NULL CHECK (length(parameter) BETWEEN 4 AND 40 AND (parameter LIKE '%_mm' OR parameter LIKE '%_rad')),
  value REAL NOT NULL CHECK (value BETWEEN -1e5 AND 1e5),
  PRIMARY KEY (campaign_id, chain, parameter)
) STRICT;

-- Its drives, one a chain.
CREATE TABLE drive (
  campaign_id INTEGER NOT NULL REFERENCES machine,
  drive INTEGER NOT NULL CHECK (drive BETWEEN 1 AND 3),
  lead_mm REAL NOT NULL CHECK (lead_mm > 0 AND lead_mm <= 1e4),
  l_min_mm REAL NOT NULL CHECK (l_min_mm BETWEEN -1e5 AND 1e5),
  l_max_mm REAL NOT NULL CHECK (l_max_mm BETWEEN -1e5 AND 1e5 AND l_max_mm > l_min_mm),
  PRIMARY KEY (campaign_id, drive)
) STRICT;

-- Free text by key: instrument, serial number, operator, …
CREATE TABLE campaign_fact (
  campaign_id INTEGER NOT NULL REFERENCES campaign,
  key TEXT NOT NULL CHECK (length(key) BETWEEN 1 AND 200),
  value TEXT NOT NULL CHECK (length(value) <= 10000),
  PRIMARY KEY (campaign_id, key)
) STRICT;

-- A versioned computation on stored readings. Its row, with all that belongs to it, is written once.
-- Jobs of databases before version 5 keep the key of their time: scheme 1.
CREATE TABLE job (
  job_id INTEGER PRIMARY KEY,
  campaign_id INTEGER NOT NULL REFERENCES campaign,
  key TEXT NOT NULL CHECK (length(key) = 64),
  key_scheme INTEGER NOT NULL CHECK (key_scheme IN (1, 2)),
  run INTEGER NOT NULL CHECK (run >= 1),
  stage TEXT NOT NULL CHECK (length(stage) BETWEEN 1 AND 100),
  algorithm_version INTEGER NOT NULL CHECK (algorithm_version >= 1),
  parameters_json TEXT NOT NULL CHECK (length(parameters_json) >= 2),
  model_json TEXT NOT NULL CHECK (length(model_json) >= 2),
  result_json TEXT NOT NULL CHECK (length(result_json) >= 2),
  n_readings INTEGER NOT NULL CHECK (n_readings >= 0),
  tool_version TEXT NOT NULL,
  git_revision TEXT NOT NULL,
  compiler TEXT NOT NULL,
  libraries TEXT NOT NULL,
  cpu_level TEXT NOT NULL,
  created_utc TEXT NOT NULL CHECK (length(created_utc) BETWEEN 20 AND 30),
  duration_s REAL NOT NULL CHECK (duration_s >= 0 AND duration_s <= 1e9),
  UNIQUE (campaign_id, key, run)
) STRICT;
CREATE INDEX job_by_campaign ON job (campaign_id);

-- One walk through a plan under one compensation: none (baseline: the name is empty), that of a job, or of one that
-- is only known by name, since the walk was imported.
CREATE TABLE session (
  session_id INTEGER PRIMARY KEY,
  campaign_id INTEGER NOT NULL REFERENCES campaign,
  name TEXT NOT NULL CHECK (length(name) BETWEEN 1 AND 200),
  compensation_job_id INTEGER REFERENCES job,
  compensation_name TEXT NOT NULL CHECK (length(compensation_name) <= 200),
  plan_name TEXT NOT NULL CHECK (length(plan_name) <= 200),
  n_points INTEGER NOT NULL CHECK (n_points >= 0),
  n_imported INTEGER NOT NULL CHECK (n_imported >= 0),
  n_asked INTEGER NOT NULL CHECK (n_asked >= 0),
  stage TEXT NOT NULL CHECK (length(stage) <= 1000),
  tracker TEXT NOT NULL CHECK (length(tracker) <= 1000),
  settings_json TEXT NOT NULL CHECK (length(settings_json) >= 2),
  tool_version TEXT NOT NULL,
  created_utc TEXT NOT NULL CHECK (length(created_utc) BETWEEN 20 AND 30),
  UNIQUE (campaign_id, name),
  CHECK (compensation_job_id IS NULL OR compensation_name <> '')
) STRICT;

-- What happened to a session, in order: started, paused, resumed, stopped, faulted, done.
CREATE TABLE session_event (
  event_id INTEGER PRIMARY KEY,
  session_id INTEGER NOT NULL REFERENCES session,
  number INTEGER NOT NULL CHECK (number >= 1),
  kind TEXT NOT NULL CHECK (length(kind) BETWEEN 1 AND 40),
  detail TEXT NOT NULL CHECK (length(detail) <= 10000),
  at_utc TEXT NOT NULL CHECK (length(at_utc) BETWEEN 20 AND 30),
  UNIQUE (session_id, number)
) STRICT;

-- One homing and frame set-up. The number counts set-ups in the campaign; a session that goes on
-- under an earlier session's set-up has its number.
CREATE TABLE epoch (
  epoch_id INTEGER PRIMARY KEY,
  session_id INTEGER NOT NULL REFERENCES session,
  number INTEGER NOT NULL CHECK (number BETWEEN 1 AND 1000000),
  reason TEXT NOT NULL CHECK (length(reason) <= 1000),
  opened_utc TEXT NOT NULL CHECK (length(opened_utc) BETWEEN 20 AND 30),
  UNIQUE (session_id, number)
) STRICT;

-- The plan, as checked before the first move. Imported sessions have none. What the machine has not (coordinates,
-- drives) is NULL, here and in a reading.
CREATE TABLE point (
  point_id INTEGER PRIMARY KEY,
  session_id INTEGER NOT NULL REFERENCES session,
  seq INTEGER NOT NULL CHECK (seq BETWEEN 1 AND 10000000),
  reading_set TEXT NOT NULL CHECK (reading_set IN ('identify', 'validate', 'predict')),
  target_x_mm REAL NOT NULL CHECK (target_x_mm BETWEEN -1e5 AND 1e5),
  target_y_mm REAL CHECK (target_y_mm BETWEEN -1e5 AND 1e5),
  target_phi_rad REAL CHECK (target_phi_rad BETWEEN -100 AND 100),
  approach_1 INTEGER NOT NULL CHECK (approach_1 BETWEEN -1 AND 1),
  approach_2 INTEGER CHECK (approach_2 BETWEEN -1 AND 1),
  approach_3 INTEGER CHECK (approach_3 BETWEEN -1 AND 1),
  repeat INTEGER NOT NULL CHECK (repeat BETWEEN 1 AND 1000000),
  is_reference INTEGER NOT NULL CHECK (is_reference IN (0, 1)),
  role TEXT NOT NULL CHECK (length(role) <= 100),
  planned_l1_mm REAL NOT NULL CHECK (planned_l1_mm BETWEEN -1e5 AND 1e5),
  planned_l2_mm REAL CHECK (planned_l2_mm BETWEEN -1e5 AND 1e5),
  planned_l3_mm REAL CHECK (planned_l3_mm BETWEEN -1e5 AND 1e5),
  UNIQUE (session_id, seq),
  CHECK (target_y_mm IS NOT NULL OR target_phi_rad IS NULL),
  CHECK (planned_l2_mm IS NOT NULL OR planned_l3_mm IS NULL),
  CHECK ((planned_l2_mm IS NULL) = (approach_2 IS NULL) AND (planned_l3_mm IS NULL) = (approach_3 IS NULL))
) STRICT;

-- One try at a point: written as open before the move, closed once.
CREATE TABLE attempt (
  attempt_id INTEGER PRIMARY KEY,
  point_id INTEGER NOT NULL REFERENCES point,
  number INTEGER NOT NULL CHECK (number >= 1),
  epoch_id INTEGER NOT NULL REFERENCES epoch,
  status TEXT NOT NULL CHECK (status IN ('open', 'ok', 'failed', 'interrupted')),
  n_readings INTEGER NOT NULL CHECK (n_readings >= 0 AND (status = 'ok') = (n_readings > 0)),
  detail TEXT NOT NULL CHECK (length(detail) <= 10000),
  opened_utc TEXT NOT NULL CHECK (length(opened_utc) BETWEEN 20 AND 30),
  closed_utc TEXT CHECK (length(closed_utc) BETWEEN 20 AND 30),
  CHECK ((status = 'open') = (closed_utc IS NULL)),
  UNIQUE (point_id, number)
) STRICT;
CREATE UNIQUE INDEX attempt_ok_once ON attempt (point_id) WHERE status = 'ok';
CREATE INDEX attempt_open ON attempt (status) WHERE status = 'open';

-- Raw: what was commanded and what was read. sha256 chains the campaign's readings in the order of
-- seq: digest of the previous reading's sha256 (the first: of zeros) and of what this one is, named by
-- natural keys: session, epoch, point and attempt.
CREATE TABLE reading (
  reading_id INTEGER PRIMARY KEY,
  campaign_id INTEGER NOT NULL REFERENCES campaign,
  seq INTEGER NOT NULL CHECK (seq BETWEEN 1 AND 1000000000),
  session_id INTEGER NOT NULL,
  epoch INTEGER NOT NULL,
  attempt_id INTEGER REFERENCES attempt,
  reading_set TEXT NOT NULL CHECK (reading_set IN ('identify', 'validate', 'predict')),
  target_x_mm REAL NOT NULL CHECK (target_x_mm BETWEEN -1e5 AND 1e5),
  target_y_mm REAL CHECK (target_y_mm BETWEEN -1e5 AND 1e5),
  target_phi_rad REAL CHECK (target_phi_rad BETWEEN -100 AND 100),
  cmd_l1_mm REAL NOT NULL CHECK (cmd_l1_mm BETWEEN -1e5 AND 1e5),
  cmd_l2_mm REAL CHECK (cmd_l2_mm BETWEEN -1e5 AND 1e5),
  cmd_l3_mm REAL CHECK (cmd_l3_mm BETWEEN -1e5 AND 1e5),
  from_l1_mm REAL NOT NULL CHECK (from_l1_mm BETWEEN -1e5 AND 1e5),
  from_l2_mm REAL CHECK (from_l2_mm BETWEEN -1e5 AND 1e5),
  from_l3_mm REAL CHECK (from_l3_mm BETWEEN -1e5 AND 1e5),
  x_mm REAL CHECK (x_mm BETWEEN -1e6 AND 1e6),
  y_mm REAL CHECK (y_mm BETWEEN -1e6 AND 1e6),
  phi_rad REAL CHECK (phi_rad BETWEEN -1000 AND 1000),
  encoder_l1_mm REAL CHECK (encoder_l1_mm BETWEEN -1e5 AND 1e5),
  encoder_l2_mm REAL CHECK (encoder_l2_mm BETWEEN -1e5 AND 1e5),
  encoder_l3_mm REAL CHECK (encoder_l3_mm BETWEEN -1e5 AND 1e5),
  time_s REAL CHECK (time_s BETWEEN -1e10 AND 1e10),
  temp_degc REAL CHECK (temp_degc BETWEEN -273.15 AND 1000),
  raw_reply TEXT CHECK (length(raw_reply) <= 100000),
  extra_json TEXT CHECK (length(extra_json) >= 2),
  sha256 BLOB NOT NULL CHECK (length(sha256) = 32),
  UNIQUE (campaign_id, seq),
  FOREIGN KEY (session_id, epoch) REFERENCES epoch (session_id, number),
  CHECK (target_y_mm IS NOT NULL OR target_phi_rad IS NULL),
  CHECK (cmd_l2_mm IS NOT NULL OR cmd_l3_mm IS NULL),
  CHECK ((cmd_l2_mm IS NULL) = (from_l2_mm IS NULL) AND (cmd_l3_mm IS NULL) = (from_l3_mm IS NULL)),
  CHECK ((reading_set = 'predict') = (x_mm IS NULL AND y_mm IS NULL AND phi_rad IS NULL)),
  CHECK (encoder_l1_mm IS NULL OR (encoder_l2_mm IS NULL) = (cmd_l2_mm IS NULL)
         AND (encoder_l3_mm IS NULL) = (cmd_l3_mm IS NULL)),
  CHECK (encoder_l1_mm IS NOT NULL OR encoder_l2_mm IS NULL AND encoder_l3_mm IS NULL)
) STRICT;
CREATE INDEX reading_by_session ON reading (session_id);
CREATE INDEX reading_by_attempt ON reading (attempt_id) WHERE attempt_id IS NOT NULL;

-- A reading that later jobs leave out, and why. The reading stays.
CREATE TABLE exclusion (
  exclusion_id INTEGER PRIMARY KEY,
  campaign_id INTEGER NOT NULL,
  seq INTEGER NOT NULL,
  reason TEXT NOT NULL CHECK (length(trim(reason)) BETWEEN 1 AND 1000),
  created_utc TEXT NOT NULL CHECK (length(created_utc) BETWEEN 20 AND 30),
  UNIQUE (campaign_id, seq),
  FOREIGN KEY (campaign_id, seq) REFERENCES reading (campaign_id, seq)
) STRICT;

-- Which sessions' readings, which exclusions, which earlier jobs, and the digest of each part of the
-- key, so that a changed input can be named.
CREATE TABLE job_session (
  job_id INTEGER NOT NULL REFERENCES job,
  session_id INTEGER NOT NULL REFERENCES session,
  PRIMARY KEY (job_id, session_id)
) STRICT;
CREATE TABLE job_exclusion (
  job_id INTEGER NOT NULL REFERENCES job,
  exclusion_id INTEGER NOT NULL REFERENCES exclusion,
  PRIMARY KEY (job_id, exclusion_id)
) STRICT;
CREATE TABLE job_parent (
  job_id INTEGER NOT NULL REFERENCES job,
  parent_job_id INTEGER NOT NULL REFERENCES job CHECK (parent_job_id <> job_id),
  PRIMARY KEY (job_id, parent_job_id)
) STRICT;
CREATE TABLE job_key_part (
  job_id INTEGER NOT NULL REFERENCES job,
  part TEXT NOT NULL CHECK (length(part) BETWEEN 1 AND 40),
  sha256 TEXT NOT NULL CHECK (length(sha256) = 64),
  PRIMARY KEY (job_id, part)
) STRICT;

-- Figures of a job. The unit ends the metric's name (position_mm, attitude_deg).
CREATE TABLE job_statistic (
  job_id INTEGER NOT NULL REFERENCES job,
  reading_set TEXT NOT NULL CHECK (length(reading_set) BETWEEN 1 AND 100),
  metric TEXT NOT NULL CHECK (length(metric) BETWEEN 1 AND 100),
  in_sample INTEGER NOT NULL CHECK (in_sample IN (0, 1)),
  phase TEXT NOT NULL CHECK (phase IN ('before', 'after')),
  mean REAL NOT NULL CHECK (mean BETWEEN -1e12 AND 1e12),
  max REAL NOT NULL CHECK (max BETWEEN -1e12 AND 1e12),
  min REAL NOT NULL CHECK (min BETWEEN -1e12 AND 1e12),
  p95 REAL NOT NULL CHECK (p95 BETWEEN -1e12 AND 1e12),
  n INTEGER NOT NULL CHECK (n >= 1),
  PRIMARY KEY (job_id, reading_set, metric, in_sample, phase)
) STRICT;

-- Of jobs stored until version 3: pose errors (measured minus target before, predicted after) of each reading they
-- looked at. Later jobs have them in their result.
CREATE TABLE job_point (
  job_id INTEGER NOT NULL REFERENCES job,
  seq INTEGER NOT NULL CHECK (seq >= 1),
  in_sample INTEGER NOT NULL CHECK (in_sample IN (0, 1)),
  before_x_mm REAL NOT NULL CHECK (before_x_mm BETWEEN -1e6 AND 1e6),
  before_y_mm REAL NOT NULL CHECK (before_y_mm BETWEEN -1e6 AND 1e6),
  before_phi_rad REAL NOT NULL CHECK (before_phi_rad BETWEEN -1000 AND 1000),
  after_x_mm REAL NOT NULL CHECK (after_x_mm BETWEEN -1e6 AND 1e6),
  after_y_mm REAL NOT NULL CHECK (after_y_mm BETWEEN -1e6 AND 1e6),
  after_phi_rad REAL NOT NULL CHECK (after_phi_rad BETWEEN -1000 AND 1000),
  PRIMARY KEY (job_id, seq)
) STRICT;

-- The campaign's models: nominal -> geometry -> +effect -> …, each a version.
CREATE TABLE model (
  model_id INTEGER PRIMARY KEY,
  campaign_id INTEGER NOT NULL REFERENCES campaign,
  version INTEGER NOT NULL CHECK (version >= 1),
  parent_model_id INTEGER REFERENCES model,
  job_id INTEGER REFERENCES job,
  name TEXT NOT NULL CHECK (length(name) BETWEEN 1 AND 200),
  parameters_json TEXT NOT NULL CHECK (length(parameters_json) >= 2),
  identify_rms_mm REAL CHECK (identify_rms_mm BETWEEN 0 AND 1e6),
  validate_rms_mm REAL CHECK (validate_rms_mm BETWEEN 0 AND 1e6),
  noise_floor_mm REAL CHECK (noise_floor_mm BETWEEN 0 AND 1e6),
  created_utc TEXT NOT NULL CHECK (length(created_utc) BETWEEN 20 AND 30),
  UNIQUE (campaign_id, version)
) STRICT;

-- Campaigns that an older database held: its version, and the end of their readings' chain there.
CREATE TABLE taken_over (
  campaign_id INTEGER PRIMARY KEY REFERENCES campaign,
  from_version INTEGER NOT NULL CHECK (from_version BETWEEN 1 AND 4),
  head BLOB NOT NULL CHECK (length(head) = 32),
  taken_utc TEXT NOT NULL CHECK (length(taken_utc) BETWEEN 20 AND 30)
) STRICT;

-- SHA-256 of every row but a reading's (those are chained), with what belongs to it, named by natural keys and written
-- with it: `db verify` walks them.
CREATE TABLE seal (
  table_name TEXT NOT NULL,
  row_id INTEGER NOT NULL,
  sha256 BLOB NOT NULL CHECK (length(sha256) = 32),
  PRIMARY KEY (table_name, row_id)
) STRICT;

-- Guards: what is stored stays. They hold for other programs too. BEFORE INSERT refuses a stored key,
-- else INSERT OR REPLACE would get past the DELETE guard where recursive_triggers is off.

CREATE TRIGGER campaign_insert BEFORE INSERT ON campaign
WHEN EXISTS (SELECT 1 FROM campaign WHERE campaign_id = NEW.campaign_id)
  OR EXISTS (SELECT 1 FROM campaign WHERE uuid = NEW.uuid)
  OR EXISTS (SELECT 1 FROM campaign WHERE name = NEW.name)
BEGIN SELECT RAISE(ABORT, 'campaign: this key is stored already, and what is stored stays'); END;
CREATE TRIGGER campaign_update BEFORE UPDATE ON campaign
BEGIN SELECT RAISE(ABORT, 'campaign: what is stored can not be changed'); END;
CREATE TRIGGER campaign_delete BEFORE DELETE ON campaign
BEGIN SELECT RAISE(ABORT, 'campaign: what is stored can not be deleted'); END;

CREATE TRIGGER machine_insert BEFORE INSERT ON machine
WHEN EXISTS (SELECT 1 FROM machine WHERE campaign_id = NEW.campaign_id)
BEGIN SELECT RAISE(ABORT, 'machine: this key is stored already, and what is stored stays'); END;
CREATE TRIGGER machine_update BEFORE UPDATE ON machine
BEGIN SELECT RAISE(ABORT, 'machine: what is stored can not be changed'); END;
CREATE TRIGGER machine_delete BEFORE DELETE ON machine
BEGIN SELECT RAISE(ABORT, 'machine: what is stored can not be deleted'); END;

CREATE TRIGGER machine_chain_insert BEFORE INSERT ON machine_chain
WHEN EXISTS (SELECT 1 FROM machine_chain WHERE campaign_id = NEW.campaign_id AND chain = NEW.chain AND parameter = NEW.parameter)
BEGIN SELECT RAISE(ABORT, 'machine_chain: this key is stored already, and what is stored stays'); END;
CREATE TRIGGER machine_chain_update BEFORE UPDATE ON machine_chain
BEGIN SELECT RAISE(ABORT, 'machine_chain: what is stored can not be changed'); END;
CREATE TRIGGER machine_chain_delete BEFORE DELETE ON machine_chain
BEGIN SELECT RAISE(ABORT, 'machine_chain: what is stored can not be deleted'); END;

CREATE TRIGGER drive_insert BEFORE INSERT ON drive
WHEN EXISTS (SELECT 1 FROM drive WHERE campaign_id = NEW.campaign_id AND drive = NEW.drive)
BEGIN SELECT RAISE(ABORT, 'drive: this key is stored already, and what is stored stays'); END;
CREATE TRIGGER drive_update BEFORE UPDATE ON drive
BEGIN SELECT RAISE(ABORT, 'drive: what is stored can not be changed'); END;
CREATE TRIGGER drive_delete BEFORE DELETE ON drive
BEGIN SELECT RAISE(ABORT, 'drive: what is stored can not be deleted'); END;

CREATE TRIGGER campaign_fact_insert BEFORE INSERT ON campaign_fact
WHEN EXISTS (SELECT 1 FROM campaign_fact WHERE campaign_id = NEW.campaign_id AND key = NEW.key)
BEGIN SELECT RAISE(ABORT, 'campaign_fact: this key is stored already, and what is stored stays'); END;
CREATE TRIGGER campaign_fact_update BEFORE UPDATE ON campaign_fact
BEGIN SELECT RAISE(ABORT, 'campaign_fact: what is stored can not be changed'); END;
CREATE TRIGGER campaign_fact_delete BEFORE DELETE ON campaign_fact
BEGIN SELECT RAISE(ABORT, 'campaign_fact: what is stored can not be deleted'); END;

CREATE TRIGGER job_insert BEFORE INSERT ON job
WHEN EXISTS (SELECT 1 FROM job WHERE job_id = NEW.job_id)
  OR EXISTS (SELECT 1 FROM job WHERE campaign_id = NEW.campaign_id AND key = NEW.key AND run = NEW.run)
BEGIN SELECT RAISE(ABORT, 'job: this key is stored already, and what is stored stays'); END;
CREATE TRIGGER job_update BEFORE UPDATE ON job
BEGIN SELECT RAISE(ABORT, 'job: what is stored can not be changed'); END;
CREATE TRIGGER job_delete BEFORE DELETE ON job
BEGIN SELECT RAISE(ABORT, 'job: what is stored can not be deleted'); END;

CREATE TRIGGER session_insert BEFORE INSERT ON session
WHEN EXISTS (SELECT 1 FROM session WHERE session_id = NEW.session_id)
  OR EXISTS (SELECT 1 FROM session WHERE campaign_id = NEW.campaign_id AND name = NEW.name)
BEGIN SELECT RAISE(ABORT, 'session: this key is stored already, and what is stored stays'); END;
CREATE TRIGGER session_update BEFORE UPDATE ON session
BEGIN SELECT RAISE(ABORT, 'session: what is stored can not be changed'); END;
CREATE TRIGGER session_delete BEFORE DELETE ON session
BEGIN SELECT RAISE(ABORT, 'session: what is stored can not be deleted'); END;

CREATE TRIGGER session_event_insert BEFORE INSERT ON session_event
WHEN EXISTS (SELECT 1 FROM session_event WHERE event_id = NEW.event_id)
  OR EXISTS (SELECT 1 FROM session_event WHERE session_id = NEW.session_id AND number = NEW.number)
BEGIN SELECT RAISE(ABORT, 'session_event: this key is stored already, and what is stored stays'); END;
CREATE TRIGGER session_event_update BEFORE UPDATE ON session_event
BEGIN SELECT RAISE(ABORT, 'session_event: what is stored can not be changed'); END;
CREATE TRIGGER session_event_delete BEFORE DELETE ON session_event
BEGIN SELECT RAISE(ABORT, 'session_event: what is stored can not be deleted'); END;

CREATE TRIGGER epoch_insert BEFORE INSERT ON epoch
WHEN EXISTS (SELECT 1 FROM epoch WHERE epoch_id = NEW.epoch_id)
  OR EXISTS (SELECT 1 FROM epoch WHERE session_id = NEW.session_id AND number = NEW.number)
BEGIN SELECT RAISE(ABORT, 'epoch: this key is stored already, and what is stored stays'); END;
CREATE TRIGGER epoch_update BEFORE UPDATE ON epoch
BEGIN SELECT RAISE(ABORT, 'epoch: what is stored can not be changed'); END;
CREATE TRIGGER epoch_delete BEFORE DELETE ON epoch
BEGIN SELECT RAISE(ABORT, 'epoch: what is stored can not be deleted'); END;

CREATE TRIGGER point_insert BEFORE INSERT ON point
WHEN EXISTS (SELECT 1 FROM point WHERE point_id = NEW.point_id)
  OR EXISTS (SELECT 1 FROM point WHERE session_id = NEW.session_id AND seq = NEW.seq)
BEGIN SELECT RAISE(ABORT, 'point: this key is stored already, and what is stored stays'); END;
CREATE TRIGGER point_update BEFORE UPDATE ON point
BEGIN SELECT RAISE(ABORT, 'point: what is stored can not be changed'); END;
CREATE TRIGGER point_delete BEFORE DELETE ON point
BEGIN SELECT RAISE(ABORT, 'point: what is stored can not be deleted'); END;

CREATE TRIGGER attempt_insert BEFORE INSERT ON attempt
WHEN EXISTS (SELECT 1 FROM attempt WHERE attempt_id = NEW.attempt_id)
  OR EXISTS (SELECT 1 FROM attempt WHERE point_id = NEW.point_id AND number = NEW.number)
BEGIN SELECT RAISE(ABORT, 'attempt: this key is stored already, and what is stored stays'); END;
CREATE TRIGGER attempt_begin BEFORE INSERT ON attempt
WHEN NEW.status <> 'open'
  OR EXISTS (SELECT 1 FROM attempt WHERE point_id = NEW.point_id AND status IN ('open', 'ok'))
  OR (SELECT session_id FROM epoch WHERE epoch_id = NEW.epoch_id)
     IS NOT (SELECT session_id FROM point WHERE point_id = NEW.point_id)
BEGIN SELECT RAISE(ABORT, 'attempt: begins as open, one at a time, in an epoch of its session, and not where one is ok'); END;
CREATE TRIGGER attempt_update BEFORE UPDATE ON attempt
WHEN OLD.status <> 'open' OR NEW.status = 'open' OR NEW.attempt_id <> OLD.attempt_id
  OR NEW.point_id <> OLD.point_id OR NEW.number <> OLD.number OR NEW.epoch_id <> OLD.epoch_id
  OR NEW.opened_utc <> OLD.opened_utc
  OR EXISTS (SELECT 1 FROM attempt WHERE point_id = OLD.point_id AND status = 'ok')
BEGIN SELECT RAISE(ABORT, 'attempt: an attempt is closed once, and nothing else of it changes'); END;
CREATE TRIGGER attempt_delete BEFORE DELETE ON attempt
BEGIN SELECT RAISE(ABORT, 'attempt: what is stored can not be deleted'); END;

CREATE TRIGGER reading_insert BEFORE INSERT ON reading
WHEN EXISTS (SELECT 1 FROM reading WHERE reading_id = NEW.reading_id)
BEGIN SELECT RAISE(ABORT, 'reading: this key is stored already, and what is stored stays'); END;
CREATE TRIGGER reading_update BEFORE UPDATE ON reading
BEGIN SELECT RAISE(ABORT, 'reading: what is stored can not be changed'); END;
CREATE TRIGGER reading_delete BEFORE DELETE ON reading
BEGIN SELECT RAISE(ABORT, 'reading: what is stored can not be deleted'); END;

CREATE TRIGGER exclusion_insert BEFORE INSERT ON exclusion
WHEN EXISTS (SELECT 1 FROM exclusion WHERE exclusion_id = NEW.exclusion_id)
  OR EXISTS (SELECT 1 FROM exclusion WHERE campaign_id = NEW.campaign_id AND seq = NEW.seq)
BEGIN SELECT RAISE(ABORT, 'exclusion: this key is stored already, and what is stored stays'); END;
CREATE TRIGGER exclusion_update BEFORE UPDATE ON exclusion
BEGIN SELECT RAISE(ABORT, 'exclusion: what is stored can not be changed'); END;
CREATE TRIGGER exclusion_delete BEFORE DELETE ON exclusion
BEGIN SELECT RAISE(ABORT, 'exclusion: what is stored can not be deleted'); END;

CREATE TRIGGER job_session_insert BEFORE INSERT ON job_session
WHEN EXISTS (SELECT 1 FROM job_session WHERE job_id = NEW.job_id AND session_id = NEW.session_id)
BEGIN SELECT RAISE(ABORT, 'job_session: this key is stored already, and what is stored stays'); END;
CREATE TRIGGER job_session_update BEFORE UPDATE ON job_session
BEGIN SELECT RAISE(ABORT, 'job_session: what is stored can not be changed'); END;
CREATE TRIGGER job_session_delete BEFORE DELETE ON job_session
BEGIN SELECT RAISE(ABORT, 'job_session: what is stored can not be deleted'); END;

CREATE TRIGGER job_exclusion_insert BEFORE INSERT ON job_exclusion
WHEN EXISTS (SELECT 1 FROM job_exclusion WHERE job_id = NEW.job_id AND exclusion_id = NEW.exclusion_id)
BEGIN SELECT RAISE(ABORT, 'job_exclusion: this key is stored already, and what is stored stays'); END;
CREATE TRIGGER job_exclusion_update BEFORE UPDATE ON job_exclusion
BEGIN SELECT RAISE(ABORT, 'job_exclusion: what is stored can not be changed'); END;
CREATE TRIGGER job_exclusion_delete BEFORE DELETE ON job_exclusion
BEGIN SELECT RAISE(ABORT, 'job_exclusion: what is stored can not be deleted'); END;

CREATE TRIGGER job_parent_insert BEFORE INSERT ON job_parent
WHEN EXISTS (SELECT 1 FROM job_parent WHERE job_id = NEW.job_id AND parent_job_id = NEW.parent_job_id)
BEGIN SELECT RAISE(ABORT, 'job_parent: this key is stored already, and what is stored stays'); END;
CREATE TRIGGER job_parent_update BEFORE UPDATE ON job_parent
BEGIN SELECT RAISE(ABORT, 'job_parent: what is stored can not be changed'); END;
CREATE TRIGGER job_parent_delete BEFORE DELETE ON job_parent
BEGIN SELECT RAISE(ABORT, 'job_parent: what is stored can not be deleted'); END;

CREATE TRIGGER job_key_part_insert BEFORE INSERT ON job_key_part
WHEN EXISTS (SELECT 1 FROM job_key_part WHERE job_id = NEW.job_id AND part = NEW.part)
BEGIN SELECT RAISE(ABORT, 'job_key_part: this key is stored already, and what is stored stays'); END;
CREATE TRIGGER job_key_part_update BEFORE UPDATE ON job_key_part
BEGIN SELECT RAISE(ABORT, 'job_key_part: what is stored can not be changed'); END;
CREATE TRIGGER job_key_part_delete BEFORE DELETE ON job_key_part
BEGIN SELECT RAISE(ABORT, 'job_key_part: what is stored can not be deleted'); END;

CREATE TRIGGER job_statistic_insert BEFORE INSERT ON job_statistic
WHEN EXISTS (SELECT 1 FROM job_statistic WHERE job_id = NEW.job_id AND reading_set = NEW.reading_set AND metric = NEW.metric AND in_sample = NEW.in_sample AND phase = NEW.phase)
BEGIN SELECT RAISE(ABORT, 'job_statistic: this key is stored already, and what is stored stays'); END;
CREATE TRIGGER job_statistic_update BEFORE UPDATE ON job_statistic
BEGIN SELECT RAISE(ABORT, 'job_statistic: what is stored can not be changed'); END;
CREATE TRIGGER job_statistic_delete BEFORE DELETE ON job_statistic
BEGIN SELECT RAISE(ABORT, 'job_statistic: what is stored can not be deleted'); END;

CREATE TRIGGER job_point_insert BEFORE INSERT ON job_point
WHEN EXISTS (SELECT 1 FROM job_point WHERE job_id = NEW.job_id AND seq = NEW.seq)
BEGIN SELECT RAISE(ABORT, 'job_point: this key is stored already, and what is stored stays'); END;
CREATE TRIGGER job_point_update BEFORE UPDATE ON job_point
BEGIN SELECT RAISE(ABORT, 'job_point: what is stored can not be changed'); END;
CREATE TRIGGER job_point_delete BEFORE DELETE ON job_point
BEGIN SELECT RAISE(ABORT, 'job_point: what is stored can not be deleted'); END;

CREATE TRIGGER model_insert BEFORE INSERT ON model
WHEN EXISTS (SELECT 1 FROM model WHERE model_id = NEW.model_id)
  OR EXISTS (SELECT 1 FROM model WHERE campaign_id = NEW.campaign_id AND version = NEW.version)
BEGIN SELECT RAISE(ABORT, 'model: this key is stored already, and what is stored stays'); END;
CREATE TRIGGER model_update BEFORE UPDATE ON model
BEGIN SELECT RAISE(ABORT, 'model: what is stored can not be changed'); END;
CREATE TRIGGER model_delete BEFORE DELETE ON model
BEGIN SELECT RAISE(ABORT, 'model: what is stored can not be deleted'); END;

CREATE TRIGGER taken_over_insert BEFORE INSERT ON taken_over
WHEN EXISTS (SELECT 1 FROM taken_over WHERE campaign_id = NEW.campaign_id)
BEGIN SELECT RAISE(ABORT, 'taken_over: this key is stored already, and what is stored stays'); END;
CREATE TRIGGER taken_over_update BEFORE UPDATE ON taken_over
BEGIN SELECT RAISE(ABORT, 'taken_over: what is stored can not be changed'); END;
CREATE TRIGGER taken_over_delete BEFORE DELETE ON taken_over
BEGIN SELECT RAISE(ABORT, 'taken_over: what is stored can not be deleted'); END;

CREATE TRIGGER seal_insert BEFORE INSERT ON seal
WHEN EXISTS (SELECT 1 FROM seal WHERE table_name = NEW.table_name AND row_id = NEW.row_id)
BEGIN SELECT RAISE(ABORT, 'seal: this key is stored already, and what is stored stays'); END;
CREATE TRIGGER seal_update BEFORE UPDATE ON seal
BEGIN SELECT RAISE(ABORT, 'seal: what is stored can not be changed'); END;
CREATE TRIGGER seal_delete BEFORE DELETE ON seal
BEGIN SELECT RAISE(ABORT, 'seal: what is stored can not be deleted'); END;

-- A job's and a campaign's parts are written with their row: nothing is added to a sealed one.
CREATE TRIGGER machine_sealed BEFORE INSERT ON machine
WHEN EXISTS (SELECT 1 FROM seal WHERE table_name = 'campaign' AND row_id = NEW.campaign_id)
BEGIN SELECT RAISE(ABORT, 'machine: its campaign is sealed'); END;
CREATE TRIGGER machine_chain_sealed BEFORE INSERT ON machine_chain
WHEN EXISTS (SELECT 1 FROM seal WHERE table_name = 'campaign' AND row_id = NEW.campaign_id)
BEGIN SELECT RAISE(ABORT, 'machine_chain: its campaign is sealed'); END;
CREATE TRIGGER drive_sealed BEFORE INSERT ON drive
WHEN EXISTS (SELECT 1 FROM seal WHERE table_name = 'campaign' AND row_id = NEW.campaign_id)
BEGIN SELECT RAISE(ABORT, 'drive: its campaign is sealed'); END;
CREATE TRIGGER campaign_fact_sealed BEFORE INSERT ON campaign_fact
WHEN EXISTS (SELECT 1 FROM seal WHERE table_name = 'campaign' AND row_id = NEW.campaign_id)
BEGIN SELECT RAISE(ABORT, 'campaign_fact: its campaign is sealed'); END;
CREATE TRIGGER job_session_sealed BEFORE INSERT ON job_session
WHEN EXISTS (SELECT 1 FROM seal WHERE table_name = 'job' AND row_id = NEW.job_id)
BEGIN SELECT RAISE(ABORT, 'job_session: its job is sealed'); END;
CREATE TRIGGER job_exclusion_sealed BEFORE INSERT ON job_exclusion
WHEN EXISTS (SELECT 1 FROM seal WHERE table_name = 'job' AND row_id = NEW.job_id)
BEGIN SELECT RAISE(ABORT, 'job_exclusion: its job is sealed'); END;
CREATE TRIGGER job_parent_sealed BEFORE INSERT ON job_parent
WHEN EXISTS (SELECT 1 FROM seal WHERE table_name = 'job' AND row_id = NEW.job_id)
BEGIN SELECT RAISE(ABORT, 'job_parent: its job is sealed'); END;
CREATE TRIGGER job_key_part_sealed BEFORE INSERT ON job_key_part
WHEN EXISTS (SELECT 1 FROM seal WHERE table_name = 'job' AND row_id = NEW.job_id)
BEGIN SELECT RAISE(ABORT, 'job_key_part: its job is sealed'); END;
CREATE TRIGGER job_statistic_sealed BEFORE INSERT ON job_statistic
WHEN EXISTS (SELECT 1 FROM seal WHERE table_name = 'job' AND row_id = NEW.job_id)
BEGIN SELECT RAISE(ABORT, 'job_statistic: its job is sealed'); END;
CREATE TRIGGER job_point_sealed BEFORE INSERT ON job_point
WHEN EXISTS (SELECT 1 FROM seal WHERE table_name = 'job' AND row_id = NEW.job_id)
BEGIN SELECT RAISE(ABORT, 'job_point: its job is sealed'); END;
CREATE TRIGGER point_sealed BEFORE INSERT ON point
WHEN EXISTS (SELECT 1 FROM seal WHERE table_name = 'session' AND row_id = NEW.session_id)
BEGIN SELECT RAISE(ABORT, 'point: its session is sealed'); END;

-- Readings come in the order of seq; session and attempt are of the campaign, the attempt is open.
CREATE TRIGGER reading_belongs BEFORE INSERT ON reading
WHEN NOT EXISTS (SELECT 1 FROM session WHERE session_id = NEW.session_id
                 AND campaign_id = NEW.campaign_id)
  OR (NEW.attempt_id IS NOT NULL AND NOT EXISTS (
      SELECT 1 FROM attempt JOIN point USING (point_id)
      WHERE attempt_id = NEW.attempt_id AND status = 'open' AND session_id = NEW.session_id))
  OR EXISTS (SELECT 1 FROM reading WHERE campaign_id = NEW.campaign_id AND seq >= NEW.seq)
BEGIN SELECT RAISE(ABORT, 'reading: seq is not the next, or no such session or open attempt'); END;

-- The questions people ask, as views. Lengths mm, angles degrees.

-- Where each planned point stands: planned, open, ok, failed or interrupted.
CREATE VIEW v_point_status AS
SELECT campaign.name AS campaign, session.name AS session, point.session_id, point.seq,
       point.reading_set, point.role,
       CASE WHEN EXISTS (SELECT 1 FROM attempt WHERE attempt.point_id = point.point_id
                         AND status = 'ok') THEN 'ok'
            ELSE coalesce((SELECT status FROM attempt WHERE attempt.point_id = point.point_id
                           ORDER BY number DESC LIMIT 1), 'planned') END AS status,
       (SELECT count(*) FROM attempt WHERE attempt.point_id = point.point_id) AS n_attempts
FROM point JOIN session USING (session_id) JOIN campaign USING (campaign_id);

-- Measured minus target of every reading, and under what it was taken. Coordinates that are not measured are NULL
-- and no part of a position's error. The target has an integer key: one for 50 and 49.99999999999999.
CREATE VIEW v_point_error AS
SELECT campaign.campaign_id, campaign.name AS campaign, campaign.kind, reading.session_id,
       session.name AS session, coalesce(job.stage, nullif(session.compensation_name, ''), 'baseline') AS method,
       session.compensation_job_id, session.compensation_name, reading.seq, reading.epoch, reading.reading_set,
       target_x_mm, target_y_mm, degrees(target_phi_rad) AS target_phi_deg,
       x_mm - target_x_mm AS error_x_mm, y_mm - target_y_mm AS error_y_mm,
       sqrt(coalesce((x_mm - target_x_mm) * (x_mm - target_x_mm), 0.0)
            + coalesce((y_mm - target_y_mm) * (y_mm - target_y_mm), 0.0)) AS position_mm,
       degrees(phi_rad - target_phi_rad) AS error_phi_deg,
       abs(degrees(phi_rad - target_phi_rad)) AS attitude_deg,
       time_s, temp_degc, exclusion.reason AS excluded,
       CAST(round(1e6 * target_x_mm) AS INTEGER) AS target_x_nm,
       CAST(round(1e6 * coalesce(target_y_mm, 0.0)) AS INTEGER) AS target_y_nm,
       CAST(round(1e6 * (coalesce(target_phi_rad, 0.0) - 6.283185307179586
         * round(coalesce(target_phi_rad, 0.0) / 6.283185307179586))) AS INTEGER) AS target_phi_urad
FROM reading JOIN campaign USING (campaign_id)
JOIN session ON session.session_id = reading.session_id
LEFT JOIN job ON job.job_id = session.compensation_job_id
LEFT JOIN exclusion ON exclusion.campaign_id = reading.campaign_id AND exclusion.seq = reading.seq
WHERE reading.reading_set <> 'predict';

-- Jobs with what they were made from and what they are worth.
CREATE VIEW v_job AS
SELECT job.job_id, campaign.name AS campaign, campaign.kind, stage, algorithm_version, run, key, key_scheme,
       n_readings,
       (SELECT group_concat(name, ' ') FROM job_session JOIN session USING (session_id)
        WHERE job_session.job_id = job.job_id) AS sessions,
       (SELECT count(*) FROM job_exclusion WHERE job_exclusion.job_id = job.job_id)
         AS n_exclusions,
       (SELECT group_concat(parent_job_id, ' ') FROM job_parent
        WHERE job_parent.job_id = job.job_id) AS parents,
       parameters_json, job.created_utc, duration_s, tool_version, git_revision, cpu_level
FROM job JOIN campaign USING (campaign_id);

CREATE VIEW v_job_point AS
WITH predicted AS (
  SELECT job_id, seq, in_sample, after_x_mm, after_y_mm, after_phi_rad FROM job_point
  UNION ALL
  SELECT job.job_id, max(CASE part.key WHEN 'seq' THEN item.value END),
         max(CASE part.key WHEN 'in_sample' THEN item.value END),
         max(CASE part.key WHEN 'x_mm' THEN item.value END),
         max(CASE part.key WHEN 'y_mm' THEN item.value END),
         max(CASE part.key WHEN 'phi_rad' THEN item.value END)
  FROM job, json_each(job.result_json, '$.points') AS part, json_each(part.value) AS item
  GROUP BY job.job_id, item.key
)
SELECT predicted.job_id, campaign.name AS campaign, campaign.kind, job.stage, predicted.seq, in_sample,
       target_x_mm, target_y_mm, degrees(target_phi_rad) AS target_phi_deg,
       x_mm - target_x_mm AS before_x_mm, y_mm - target_y_mm AS before_y_mm,
       degrees(phi_rad - target_phi_rad) AS before_phi_deg,
       after_x_mm, after_y_mm, degrees(after_phi_rad) AS after_phi_deg
FROM predicted JOIN job USING (job_id) JOIN campaign USING (campaign_id)
JOIN reading ON reading.campaign_id = job.campaign_id AND reading.seq = predicted.seq;

-- Before and after per campaign, session and method. Two sources, never mixed: `predicted` is what a
-- job states of its own fit; `measured` compares a compensated session, target by target, with the
-- baseline session that shares most of its targets (of equals the first). in_sample: judged at points
-- that were fitted. p95 interpolates between order statistics.
CREATE VIEW v_accuracy AS
WITH figure AS (
  SELECT campaign_id, campaign, kind, session_id, session, method, compensation_job_id, compensation_name,
         reading_set, 'position_mm' AS metric, position_mm AS value,
         target_x_nm, target_y_nm, target_phi_urad
  FROM v_point_error WHERE excluded IS NULL
  UNION ALL
  SELECT campaign_id, campaign, kind, session_id, session, method, compensation_job_id, compensation_name,
         reading_set, 'attitude_deg', attitude_deg, target_x_nm, target_y_nm, target_phi_urad
  FROM v_point_error WHERE excluded IS NULL
), shared AS (
  SELECT compensated.session_id, plain.session_id AS baseline_id,
         row_number() OVER (PARTITION BY compensated.session_id
                            ORDER BY count(*) DESC, plain.session_id) AS rank
  FROM figure AS compensated
  JOIN figure AS plain USING (campaign_id, metric, target_x_nm, target_y_nm, target_phi_urad)
  WHERE metric = 'position_mm' AND compensated.compensation_name <> ''
    AND plain.compensation_name = ''
  GROUP BY compensated.session_id, plain.session_id
), baseline AS (
  SELECT shared.session_id, metric, target_x_nm, target_y_nm, target_phi_urad, avg(value) AS value
  FROM shared JOIN figure ON figure.session_id = shared.baseline_id
  WHERE rank = 1
  GROUP BY shared.session_id, metric, target_x_nm, target_y_nm, target_phi_urad
), fit AS (
  SELECT DISTINCT predicted.job_id, target_x_nm, target_y_nm FROM v_job_point AS predicted
  JOIN job USING (job_id)
  JOIN v_point_error AS seen ON seen.campaign_id = job.campaign_id AND seen.seq = predicted.seq
  WHERE in_sample = 1 AND predicted.job_id IN (SELECT compensation_job_id FROM session)
), pair AS (
  SELECT figure.*, baseline.value AS before,
         EXISTS (SELECT 1 FROM fit WHERE fit.job_id = figure.compensation_job_id
                 AND fit.target_x_nm = figure.target_x_nm
                 AND fit.target_y_nm = figure.target_y_nm) AS fitted
  FROM figure JOIN baseline USING (session_id, metric, target_x_nm, target_y_nm, target_phi_urad)
  WHERE figure.compensation_name <> ''
), ranked AS (
  SELECT *, count(*) OVER (PARTITION BY session_id, reading_set, metric, fitted) AS n,
         row_number() OVER (PARTITION BY session_id, reading_set, metric, fitted
                            ORDER BY before) - 1 AS before_rank,
         row_number() OVER (PARTITION BY session_id, reading_set, metric, fitted
                            ORDER BY value) - 1 AS after_rank
  FROM pair
)
SELECT campaign, kind, session, method, 'measured' AS source, reading_set, metric,
       fitted AS in_sample, n,
       avg(before) AS before_mean, max(before) AS before_max, min(before) AS before_min,
       sum(before * max(0.0, 1 - abs(before_rank - 0.95 * (n - 1)))) AS before_p95,
       avg(value) AS after_mean, max(value) AS after_max, min(value) AS after_min,
       sum(value * max(0.0, 1 - abs(after_rank - 0.95 * (n - 1)))) AS after_p95,
       100 * (1 - avg(value) / nullif(avg(before), 0)) AS improvement_pct
FROM ranked GROUP BY session_id, reading_set, metric, fitted
UNION ALL
SELECT campaign.name, campaign.kind, (SELECT group_concat(name, ' ') FROM job_session
       JOIN session USING (session_id) WHERE job_session.job_id = job.job_id),
       stage, 'predicted', b.reading_set, b.metric, b.in_sample, b.n,
       b.mean, b.max, b.min, b.p95, a.mean, a.max, a.min, a.p95,
       100 * (1 - a.mean / nullif(b.mean, 0))
FROM job JOIN campaign USING (campaign_id)
JOIN job_statistic AS b ON b.job_id = job.job_id AND b.phase = 'before'
JOIN job_statistic AS a ON a.job_id = job.job_id AND a.phase = 'after'
  AND a.reading_set = b.reading_set AND a.metric = b.metric AND a.in_sample = b.in_sample;

-- What moved between visits: the same command from the same side, compared with the first visit in
-- its session. n_visits = 1 tells nothing and is left out.
CREATE VIEW v_drift AS
WITH visit AS (
  SELECT campaign.name AS campaign, session.name AS session, reading.seq, reading.epoch, time_s,
         temp_degc, x_mm, y_mm, phi_rad, reading.target_x_mm, reading.target_y_mm,
         degrees(reading.target_phi_rad) AS target_phi_deg, coalesce(point.is_reference, 0) AS is_reference,
         count(*) OVER same AS n_visits,
         row_number() OVER (same ORDER BY reading.seq) AS visit,
         first_value(x_mm) OVER (same ORDER BY reading.seq) AS first_x_mm,
         first_value(y_mm) OVER (same ORDER BY reading.seq) AS first_y_mm,
         first_value(phi_rad) OVER (same ORDER BY reading.seq) AS first_phi_rad,
         first_value(temp_degc) OVER (same ORDER BY reading.seq) AS first_temp_degc
  FROM reading JOIN campaign USING (campaign_id)
  JOIN session ON session.session_id = reading.session_id
  LEFT JOIN attempt ON attempt.attempt_id = reading.attempt_id
  LEFT JOIN point ON point.point_id = attempt.point_id
  WHERE reading.reading_set <> 'predict'
  WINDOW same AS (PARTITION BY reading.session_id, cmd_l1_mm, cmd_l2_mm, cmd_l3_mm,
                  sign(cmd_l1_mm - from_l1_mm), sign(cmd_l2_mm - from_l2_mm),
                  sign(cmd_l3_mm - from_l3_mm))
)
SELECT campaign, session, seq, epoch, is_reference, visit, n_visits, time_s, temp_degc,
       target_x_mm, target_y_mm, target_phi_deg,
       x_mm - first_x_mm AS drift_x_mm, y_mm - first_y_mm AS drift_y_mm,
       degrees(phi_rad - first_phi_rad) AS drift_phi_deg,
       temp_degc - first_temp_degc AS drift_temp_degc
FROM visit WHERE n_visits > 1;
