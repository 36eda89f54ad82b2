-- The archive of many stations, version 1. PostgreSQL 15 or later. app/archive/README.md explains it.
-- Rows only come: what is stored is neither changed nor deleted, by nobody, its owner included. What arrives is
-- looked through here, whatever program sent it: each row's SHA-256, the chain of readings, whose campaign it is.
-- Units stand in the column names, as in schemas/sql. Times of day of a station are its own; received_at is ours.
CREATE SCHEMA trammel;
SET LOCAL search_path = trammel, pg_catalog;

CREATE TABLE trammel.archive (
  version int NOT NULL PRIMARY KEY CHECK (version >= 1),
  made_at timestamptz NOT NULL DEFAULT now()
);
INSERT INTO trammel.archive (version) VALUES (1);

-- A station is one database file's identity, and the role that first came with it.
CREATE TABLE trammel.station (
  uuid text PRIMARY KEY CHECK (length(uuid) = 36),
  role name NOT NULL,
  first_at timestamptz NOT NULL DEFAULT now()
);

-- The end of what a campaign has stored here. head: sha256 of its last reading (without readings: zeros);
-- rows_sha256: SHA-256 over the digests of its other rows, in the order of their bytes.
CREATE TABLE trammel.campaign_head (
  campaign text PRIMARY KEY CHECK (length(campaign) = 36),
  station text NOT NULL REFERENCES trammel.station,
  head bytea NOT NULL CHECK (length(head) = 32),
  last_seq bigint NOT NULL DEFAULT 0,
  n_readings bigint NOT NULL DEFAULT 0,
  rows_sha256 bytea NOT NULL DEFAULT sha256('') CHECK (length(rows_sha256) = 32),
  n_rows bigint NOT NULL DEFAULT 0,
  moved_at timestamptz NOT NULL DEFAULT now()
);
CREATE INDEX campaign_head_newest ON trammel.campaign_head (moved_at DESC);
CREATE INDEX campaign_head_station ON trammel.campaign_head (station);

-- Every sealed row of a station, with what belongs to it: the bytes that its digest was taken over (store/digest.hpp):
-- for each part k of its table's list (store/seal.cpp) the integer k, then n_rows[k + 1] rows. row_key: the bytes of
-- its natural key, with which those of its first part begin. row_ids: the station's own numbers of the row and of the
-- rows of its parts that have one, so that a file can be made again as it was. (A reference to campaign_head would be
-- asked for each row; rows_arrived and readings_arrived ask it once.)
CREATE TABLE trammel.archive_row (
  campaign text NOT NULL,
  table_name text NOT NULL CHECK (table_name IN ('campaign', 'session', 'session_event', 'epoch', 'attempt',
                                                 'exclusion', 'job', 'model', 'taken_over')),
  row_key bytea NOT NULL CHECK (length(row_key) BETWEEN 45 AND 4096),
  row_ids bigint[] NOT NULL CHECK (cardinality(row_ids) >= 1),
  n_rows int[] NOT NULL CHECK (cardinality(n_rows) BETWEEN 1 AND 16),
  bytes bytea NOT NULL CHECK (length(bytes) <= 256 * 1024 * 1024),
  sha256 bytea NOT NULL CHECK (length(sha256) = 32),
  received_at timestamptz NOT NULL DEFAULT now(),
  PRIMARY KEY (campaign, table_name, row_key)
);

-- Readings come as numbers; trammel.bytes_of(reading) are the bytes that their chain is taken over.
CREATE TABLE trammel.reading (
  campaign text NOT NULL,
  row_id bigint NOT NULL CHECK (row_id >= 1),
  seq bigint NOT NULL CHECK (seq BETWEEN 1 AND 1000000000),
  session text NOT NULL,
  epoch bigint NOT NULL,
  point bigint,
  attempt bigint,
  reading_set text NOT NULL CHECK (reading_set IN ('identify', 'validate', 'predict')),
  target_x_mm float8 NOT NULL,
  target_y_mm float8,
  target_phi_rad float8,
  cmd_l1_mm float8 NOT NULL,
  cmd_l2_mm float8,
  cmd_l3_mm float8,
  from_l1_mm float8 NOT NULL,
  from_l2_mm float8,
  from_l3_mm float8,
  x_mm float8,
  y_mm float8,
  phi_rad float8,
  encoder_l1_mm float8,
  encoder_l2_mm float8,
  encoder_l3_mm float8,
  time_s float8,
  temp_degc float8,
  raw_reply bytea CHECK (length(raw_reply) <= 400000),
  extra_json text,
  sha256 bytea NOT NULL CHECK (length(sha256) = 32),
  received_at timestamptz NOT NULL DEFAULT now(),
  PRIMARY KEY (campaign, seq)
);

-- What a list of campaigns names; what else people ask for stands in 0002.
CREATE TABLE trammel.campaign (
  campaign text PRIMARY KEY REFERENCES trammel.campaign_head,
  campaign_id bigint NOT NULL,
  name text NOT NULL,
  kind text NOT NULL,
  origin text NOT NULL,
  created_utc text NOT NULL,
  tracker_sigma_xy_mm float8,
  tracker_sigma_phi_rad float8,
  machine text
);
-- Canonical bytes of a value: n; i or r and 8 bytes, big-endian; t or b, 8 bytes of length and the bytes.
CREATE FUNCTION trammel.canonical(v bigint) RETURNS bytea LANGUAGE sql IMMUTABLE PARALLEL SAFE AS
$$ SELECT CASE WHEN v IS NULL THEN '\x6e'::bytea ELSE '\x69'::bytea || int8send(v) END $$;
CREATE FUNCTION trammel.canonical(v float8) RETURNS bytea LANGUAGE sql IMMUTABLE PARALLEL SAFE AS
$$ SELECT CASE WHEN v IS NULL THEN '\x6e'::bytea ELSE '\x72'::bytea || float8send(v) END $$;
CREATE FUNCTION trammel.canonical_text(v bytea) RETURNS bytea LANGUAGE sql IMMUTABLE PARALLEL SAFE AS
$$ SELECT CASE WHEN v IS NULL THEN '\x6e'::bytea ELSE '\x74'::bytea || int8send(length(v)::bigint) || v END $$;
CREATE FUNCTION trammel.canonical(v text) RETURNS bytea LANGUAGE sql STABLE PARALLEL SAFE AS
$$ SELECT CASE WHEN v IS NULL THEN '\x6e'::bytea
               ELSE '\x74'::bytea || int8send(octet_length(v)::bigint) || convert_to(v, 'UTF8') END $$;

-- What a reading is, in the order of kChainedReadings (store/reading.cpp).
CREATE FUNCTION trammel.bytes_of(r trammel.reading) RETURNS bytea LANGUAGE sql STABLE PARALLEL SAFE AS $$
  SELECT trammel.canonical(r.seq) || trammel.canonical(r.session) || trammel.canonical(r.epoch)
      || trammel.canonical(r.point) || trammel.canonical(r.attempt) || trammel.canonical(r.reading_set)
      || trammel.canonical(r.target_x_mm) || trammel.canonical(r.target_y_mm) || trammel.canonical(r.target_phi_rad)
      || trammel.canonical(r.cmd_l1_mm) || trammel.canonical(r.cmd_l2_mm) || trammel.canonical(r.cmd_l3_mm)
      || trammel.canonical(r.from_l1_mm) || trammel.canonical(r.from_l2_mm) || trammel.canonical(r.from_l3_mm)
      || trammel.canonical(r.x_mm) || trammel.canonical(r.y_mm) || trammel.canonical(r.phi_rad)
      || trammel.canonical(r.encoder_l1_mm) || trammel.canonical(r.encoder_l2_mm) || trammel.canonical(r.encoder_l3_mm)
      || trammel.canonical(r.time_s) || trammel.canonical(r.temp_degc)
      || trammel.canonical_text(r.raw_reply) || trammel.canonical(r.extra_json)
$$;
CREATE FUNCTION trammel.link(before bytea, bytes bytea) RETURNS bytea LANGUAGE sql IMMUTABLE PARALLEL SAFE AS
$$ SELECT sha256('\x62'::bytea || int8send(32) || before || bytes) $$;
CREATE FUNCTION trammel.chain_start() RETURNS bytea LANGUAGE sql IMMUTABLE PARALLEL SAFE AS
$$ SELECT decode(repeat('00', 32), 'hex') $$;

-- The double of 8 bytes: sign, exponent and fraction are exact, and so is their product.
CREATE FUNCTION trammel.real_of(b bytea) RETURNS float8 LANGUAGE plpgsql IMMUTABLE PARALLEL SAFE AS $$
DECLARE
  bits bigint := ('x' || encode(b, 'hex'))::bit(64)::bigint;
  exponent int := (bits >> 52) & 2047;
  fraction bigint := bits & 4503599627370495;
  sign float8 := CASE WHEN bits < 0 THEN -1 ELSE 1 END;
BEGIN
  IF exponent = 2047 THEN RAISE EXCEPTION 'a number that is not finite' USING ERRCODE = 'data_exception'; END IF;
  IF exponent = 0 THEN RETURN sign * (fraction::float8 * power(2::float8, -1074)); END IF;
  RETURN sign * ((fraction + 4503599627370496)::float8 * power(2::float8, exponent - 1075));
END $$;

-- How many columns each part of a sealed table has (store/seal.cpp).
CREATE FUNCTION trammel.widths_of(table_name text) RETURNS int[] LANGUAGE sql IMMUTABLE PARALLEL SAFE AS $$
  SELECT CASE table_name WHEN 'campaign' THEN '{7,7,3,4,2}'::int[] WHEN 'session' THEN '{14,14}' WHEN 'session_event' THEN '{6}'
                         WHEN 'epoch' THEN '{5}' WHEN 'attempt' THEN '{10}' WHEN 'exclusion' THEN '{4}'
                         WHEN 'job' THEN '{17,1,1,2,2,9,8}' WHEN 'model' THEN '{11}' WHEN 'taken_over' THEN '{4}' END $$;

-- The rows of a part of canonical bytes, values as texts: a double's has the shortest digits that give its bits again,
-- a blob's is hex. Without doubles where `with_reals` is false: those take longest.
CREATE FUNCTION trammel.part_of(table_name text, bytes bytea, n_rows int[], part int, with_reals boolean DEFAULT true)
RETURNS SETOF text[] LANGUAGE plpgsql IMMUTABLE PARALLEL SAFE AS $$
DECLARE
  whole CONSTANT bytea := bytes || ''::bytea;  -- out of its compression once, not at each look
  ends CONSTANT int := length(whole);
  widths CONSTANT int[] := trammel.widths_of(table_name);
  found text[];
  at int := 0;
  size bigint;
  kind int;
BEGIN
  FOR p IN 1 .. part LOOP
    at := at + 9;  -- the part's number
    FOR r IN 1 .. n_rows[p] LOOP
      found := '{}';
      FOR c IN 1 .. widths[p] LOOP
        IF at >= ends THEN RAISE EXCEPTION 'canonical bytes end before their rows do'; END IF;
        kind := get_byte(whole, at);
        IF kind = 110 THEN
          IF p = part THEN found := found || NULL::text; END IF;
          at := at + 1;
          CONTINUE;
        END IF;
        at := at + 9;
        IF at > ends THEN RAISE EXCEPTION 'canonical bytes end in a value'; END IF;
        IF kind = 114 AND (p < part OR NOT with_reals) THEN
          IF p = part THEN found := found || NULL::text; END IF;
          CONTINUE;
        END IF;
        IF kind = 114 THEN
          found := found || trammel.real_of(substr(whole, at - 7, 8))::text;
          CONTINUE;
        END IF;
        size := ('x' || encode(substr(whole, at - 7, 8), 'hex'))::bit(64)::bigint;
        IF kind = 105 THEN
          IF p = part THEN found := found || size::text; END IF;
        ELSIF kind IN (116, 98) THEN
          IF size < 0 OR size > ends - at THEN RAISE EXCEPTION 'canonical bytes end in a value'; END IF;
          IF p = part THEN
            found := found || CASE kind WHEN 116 THEN convert_from(substr(whole, at + 1, size::int), 'UTF8')
                                        ELSE encode(substr(whole, at + 1, size::int), 'hex') END;
          END IF;
          at := at + size::int;
        ELSE
          RAISE EXCEPTION 'canonical bytes have no value of kind %', kind;
        END IF;
      END LOOP;
      IF p = part THEN RETURN NEXT found; END IF;
    END LOOP;
  END LOOP;
END $$;

CREATE FUNCTION trammel.campaign_of(a trammel.archive_row) RETURNS SETOF trammel.campaign LANGUAGE sql STABLE AS $$
  SELECT v[1], a.row_ids[1], v[2], v[3], v[4], v[5], v[6]::float8, v[7]::float8,
         (SELECT m[1] FROM trammel.part_of('campaign', a.bytes, a.n_rows, 2) AS m)
  FROM trammel.part_of('campaign', a.bytes, a.n_rows, 1) AS v $$;

CREATE FUNCTION trammel.rows_sha256(of_campaign text) RETURNS bytea LANGUAGE sql STABLE AS $$
  SELECT sha256(coalesce(string_agg(sha256, ''::bytea ORDER BY sha256), ''::bytea))
  FROM trammel.archive_row WHERE campaign = of_campaign $$;

-- A station is one role's: the first that came with it.
CREATE FUNCTION trammel.require_station(of_uuid text) RETURNS void
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp AS $$
BEGIN
  IF EXISTS (SELECT 1 FROM trammel.station WHERE uuid = of_uuid AND role = session_user) THEN RETURN; END IF;
  INSERT INTO trammel.station (uuid, role) VALUES (of_uuid, session_user) ON CONFLICT DO NOTHING;
  IF NOT EXISTS (SELECT 1 FROM trammel.station WHERE uuid = of_uuid AND role = session_user) THEN
    RAISE EXCEPTION 'station % is another role''s', of_uuid USING ERRCODE = 'insufficient_privilege';
  END IF;
END $$;

-- Begins a push: the campaign's head, held until the transaction ends, made where the campaign is new. A campaign is
-- one station's, a station one role's.
CREATE FUNCTION trammel.begin_push(of_campaign text, by_station text) RETURNS trammel.campaign_head
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp AS $$
DECLARE
  head trammel.campaign_head;
BEGIN
  PERFORM trammel.require_station(by_station);
  INSERT INTO trammel.campaign_head (campaign, station, head)
    VALUES (of_campaign, by_station, trammel.chain_start()) ON CONFLICT DO NOTHING;
  SELECT * INTO head FROM trammel.campaign_head WHERE campaign = of_campaign FOR UPDATE;
  RETURN head;
END $$;

-- Who inserts must be the role of the campaign's station.
CREATE FUNCTION trammel.held_head(of_campaign text) RETURNS trammel.campaign_head
LANGUAGE plpgsql SET search_path = pg_catalog, pg_temp AS $$
DECLARE
  head trammel.campaign_head;
BEGIN
  SELECT h.* INTO head FROM trammel.campaign_head AS h JOIN trammel.station ON station.uuid = h.station
    WHERE h.campaign = of_campaign AND station.role = session_user FOR UPDATE OF h;
  IF NOT FOUND THEN
    RAISE EXCEPTION 'campaign % is not of a station of role %', of_campaign, session_user
      USING ERRCODE = 'insufficient_privilege';
  END IF;
  RETURN head;
END $$;

-- A plan that was made while the tables were empty would walk them whole ever after: enable_seqscan is off. One plan
-- serves all. Machine code for it (jit) would be made at each call, since a plan that may not walk tables counts as dear:
-- 20 ms a campaign of 80 readings, five times all else.
CREATE FUNCTION trammel.rows_arrived() RETURNS trigger
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp SET enable_seqscan = off SET jit = off
SET plan_cache_mode = force_generic_plan AS $$
DECLARE
  bad record;
  one record;
BEGIN
  SELECT a.table_name, a.campaign INTO bad FROM arrived AS a
    WHERE a.sha256 <> sha256(a.bytes)
       OR substr(a.bytes, 1, 9) <> '\x690000000000000000'::bytea
       OR substr(a.bytes, 10, length(a.row_key)) <> a.row_key
       OR substr(a.row_key, 1, 45) <> trammel.canonical(a.campaign)
    LIMIT 1;
  IF FOUND THEN
    RAISE EXCEPTION 'a row of % of campaign % is not what its digest and its key say', bad.table_name, bad.campaign
      USING ERRCODE = 'data_corrupted';
  END IF;
  FOR one IN SELECT campaign, count(*) AS n FROM arrived GROUP BY campaign ORDER BY campaign LOOP
    PERFORM trammel.held_head(one.campaign);
    UPDATE trammel.campaign_head SET rows_sha256 = trammel.rows_sha256(one.campaign), n_rows = n_rows + one.n,
      moved_at = now() WHERE campaign = one.campaign;
  END LOOP;
  RETURN NULL;
END $$;

CREATE FUNCTION trammel.readings_arrived() RETURNS trigger
LANGUAGE plpgsql SECURITY DEFINER SET search_path = pg_catalog, pg_temp SET enable_seqscan = off SET jit = off
SET plan_cache_mode = force_generic_plan AS $$
DECLARE
  before trammel.campaign_head;
  bad record;
  one record;
BEGIN
  FOR one IN SELECT campaign, count(*) AS n, min(seq) AS first, max(seq) AS last FROM arrived
             GROUP BY campaign ORDER BY campaign LOOP
    before := trammel.held_head(one.campaign);
    IF one.first <= before.last_seq THEN
      RAISE EXCEPTION 'reading % of campaign % is not behind the last one, %', one.first, one.campaign, before.last_seq
        USING ERRCODE = 'data_corrupted';
    END IF;
    SELECT walked.seq INTO bad FROM (
      SELECT a.seq, a.sha256, trammel.link(coalesce(lag(a.sha256) OVER (ORDER BY a.seq), before.head),
                                           trammel.bytes_of(a)) AS expected
      FROM trammel.reading AS a WHERE a.campaign = one.campaign AND a.seq > before.last_seq) AS walked
    WHERE walked.sha256 <> walked.expected ORDER BY walked.seq LIMIT 1;
    IF FOUND THEN
      RAISE EXCEPTION 'reading % of campaign % is not what its chain says', bad.seq, one.campaign
        USING ERRCODE = 'data_corrupted';
    END IF;
    UPDATE trammel.campaign_head SET
      head = (SELECT sha256 FROM trammel.reading WHERE campaign = one.campaign AND seq = one.last),
      last_seq = one.last, n_readings = n_readings + one.n, moved_at = now() WHERE campaign = one.campaign;
  END LOOP;
  RETURN NULL;
END $$;

CREATE TRIGGER arrived AFTER INSERT ON trammel.archive_row REFERENCING NEW TABLE AS arrived
  FOR EACH STATEMENT EXECUTE FUNCTION trammel.rows_arrived();
CREATE TRIGGER arrived AFTER INSERT ON trammel.reading REFERENCING NEW TABLE AS arrived
  FOR EACH STATEMENT EXECUTE FUNCTION trammel.readings_arrived();

-- What is stored stays.
CREATE FUNCTION trammel.refuse() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  RAISE EXCEPTION '%: what is stored can not be changed or deleted', TG_TABLE_NAME
    USING ERRCODE = 'insufficient_privilege';
END $$;
DO $$
DECLARE
  name text;
BEGIN
  FOREACH name IN ARRAY ARRAY['archive_row', 'reading', 'campaign', 'station'] LOOP
    EXECUTE format('CREATE TRIGGER stays BEFORE UPDATE OR DELETE OR TRUNCATE ON trammel.%I '
                   'FOR EACH STATEMENT EXECUTE FUNCTION trammel.refuse()', name);
  END LOOP;
END $$;
-- A head moves on, and never back.
CREATE FUNCTION trammel.head_moves_on() RETURNS trigger LANGUAGE plpgsql AS $$
BEGIN
  IF NEW.campaign <> OLD.campaign OR NEW.station <> OLD.station OR NEW.n_readings < OLD.n_readings
     OR NEW.last_seq < OLD.last_seq OR NEW.n_rows < OLD.n_rows
     OR NEW.n_readings = OLD.n_readings AND NEW.head <> OLD.head
     OR NEW.n_rows = OLD.n_rows AND NEW.rows_sha256 <> OLD.rows_sha256 THEN
    RAISE EXCEPTION 'campaign_head: a head moves on, and never back' USING ERRCODE = 'insufficient_privilege';
  END IF;
  RETURN NEW;
END $$;
CREATE TRIGGER moves_on BEFORE UPDATE ON trammel.campaign_head
  FOR EACH ROW EXECUTE FUNCTION trammel.head_moves_on();
CREATE TRIGGER stays BEFORE DELETE OR TRUNCATE ON trammel.campaign_head
  FOR EACH STATEMENT EXECUTE FUNCTION trammel.refuse();

-- Everything that was sent, recomputed: one sentence for each thing that is not what was stored.
CREATE FUNCTION trammel.stored_findings() RETURNS SETOF text LANGUAGE sql STABLE AS $$
  SELECT format('campaign %s: a row of %s is not what its digest says', campaign, table_name)
  FROM trammel.archive_row WHERE sha256 <> sha256(bytes)
  UNION ALL
  SELECT format('campaign %s: reading %s, or the one before it, is not what was stored', campaign, seq)
  FROM (SELECT r.campaign, r.seq, r.sha256,
               trammel.link(coalesce(lag(r.sha256) OVER (PARTITION BY r.campaign ORDER BY r.seq),
                                     trammel.chain_start()), trammel.bytes_of(r)) AS expected
        FROM trammel.reading AS r) AS walked
  WHERE sha256 <> expected
  UNION ALL
  SELECT format('campaign %s: %s readings ending in %s, and its head says %s ending in %s', h.campaign,
                count(r.seq), encode(coalesce((array_agg(r.sha256 ORDER BY r.seq DESC))[1],
                                              trammel.chain_start()), 'hex'),
                h.n_readings, encode(h.head, 'hex'))
  FROM trammel.campaign_head AS h LEFT JOIN trammel.reading AS r USING (campaign)
  GROUP BY h.campaign
  HAVING count(r.seq) <> h.n_readings
      OR coalesce((array_agg(r.sha256 ORDER BY r.seq DESC))[1], trammel.chain_start()) <> h.head
  UNION ALL
  SELECT format('campaign %s: its other rows are not those that its head says', campaign)
  FROM trammel.campaign_head AS h
  WHERE trammel.rows_sha256(campaign) <> rows_sha256
     OR (SELECT count(*) FROM trammel.archive_row AS r WHERE r.campaign = h.campaign) <> n_rows
$$;

-- Who may what: a station appends and reads, a reader reads. A worker is a station of its own.
DO $$
DECLARE
  name text;
BEGIN
  FOREACH name IN ARRAY ARRAY['trammel_station', 'trammel_worker', 'trammel_reader'] LOOP
    IF NOT EXISTS (SELECT 1 FROM pg_roles WHERE rolname = name) THEN EXECUTE format('CREATE ROLE %I NOLOGIN', name); END IF;
  END LOOP;
END $$;
REVOKE ALL ON SCHEMA trammel FROM PUBLIC;
REVOKE ALL ON ALL FUNCTIONS IN SCHEMA trammel FROM PUBLIC;
GRANT USAGE ON SCHEMA trammel TO trammel_station, trammel_worker, trammel_reader;
GRANT SELECT ON ALL TABLES IN SCHEMA trammel TO trammel_station, trammel_worker, trammel_reader;
GRANT EXECUTE ON ALL FUNCTIONS IN SCHEMA trammel TO trammel_station, trammel_worker, trammel_reader;
REVOKE EXECUTE ON FUNCTION trammel.begin_push, trammel.require_station FROM trammel_reader;
GRANT INSERT (campaign, table_name, row_key, row_ids, n_rows, bytes, sha256) ON trammel.archive_row
  TO trammel_station, trammel_worker;
GRANT INSERT (campaign, row_id, seq, session, epoch, point, attempt, reading_set, target_x_mm, target_y_mm,
  target_phi_rad, cmd_l1_mm, cmd_l2_mm, cmd_l3_mm, from_l1_mm, from_l2_mm, from_l3_mm, x_mm, y_mm, phi_rad,
  encoder_l1_mm, encoder_l2_mm, encoder_l3_mm, time_s, temp_degc, raw_reply, extra_json, sha256) ON trammel.reading
  TO trammel_station, trammel_worker;
