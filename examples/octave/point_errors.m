% Where the robot stood: octave point_errors.m LABORATORY.db SESSION [MAP.png]
% Octave reads no SQLite: trammel hands it a table, which stays in a file of its own until the end.
words = argv();
if numel(words) < 2
  fprintf(stderr, "octave point_errors.m LABORATORY.db SESSION [MAP.png]\n");
  exit(1);
end
session = words{2};
table_file = [tempname() ".csv"];
sql = ["SELECT target_x_mm, target_y_mm, error_x_mm, error_y_mm, position_mm FROM v_point_error " ...
       "WHERE session = '" strrep(session, "'", "''") "' AND excluded IS NULL ORDER BY seq"];
if system(["trammel query --quiet --csv --out " table_file " --db '" words{1} "' \"" sql "\""]) != 0
  exit(1);  % trammel has said why
end
points = dlmread(table_file, ",", 1, 0);  % one header line
delete(table_file);
if isempty(points)
  fprintf(stderr, "%s: no session %s with readings\n", words{1}, session);
  exit(1);
end
position_mm = points(:, 5);
printf("%s: %d readings, mean %.4f mm, max %.4f mm\n", session, rows(points), mean(position_mm), max(position_mm));
if numel(words) > 2
  figure("visible", "off");
  quiver(points(:, 1), points(:, 2), points(:, 3), points(:, 4));
  xlabel("x mm"); ylabel("y mm"); title(["position errors of " session]);
  print(words{3}, "-dpng");
end
